// SPDX-License-Identifier: MIT
// SIGINT and SIGTERM. The first one asks the work to end at its next chance; a second one ends the process at once.
#pragma once

namespace plumb {

void catchInterrupts();
int interruptedBy();       // 0, SIGINT or SIGTERM
void stopIfInterrupted();  // throws Error(interrupted) or Error(terminated)

}  // namespace plumb
