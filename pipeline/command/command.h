// SPDX-License-Identifier: MIT
// The commands. Each returns an exit code for a verdict (0, 1, 7) and throws Error for a failure.
#pragma once

#include "host/error.h"
#include "pipeline/cli/options.h"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace plumb {

class FileBatch;
using Json = nlohmann::ordered_json;  // keys in the order in which docs/outputs.md lists them

Exit renderCommand(const Options&);
Exit verifyCommand(const Options&);
Exit replayCommand(const Options&);
Exit diffCommand(const Options&);
Exit measureCommand(const Options&);
Exit planCommand(const Options&);
Exit devicesCommand(const Options&);
Exit infoCommand(const Options&);
Exit matrixCommand(const Options&);
Exit benchCommand(const Options&);
Exit pixelCommand(const Options&);
Exit stressCommand(const Options&);
Exit helpCommand(const Options&);

// Version report of `--version`, and the "tool" of every report.
std::string versionReport();
Json toolJson();

// Exit code when standard output has lost its reader, as if SIGPIPE had ended the command: no message is printed.
inline constexpr Exit kReaderLeft = Exit(141);
// Writes data to standard output: all of it, or Error(failed); Error(kReaderLeft) when nobody reads it any more.
void printData(const std::string& text);
// Throws the errors of printData() for a standard output that is closed or has lost its reader, before there is something to write.
void expectReader();
// Finishes a command: its files are placed, `text` and the report of --json are written, and then the files are kept. A failure leaves none
// of them.
void finish(const Options&, FileBatch& files, const std::string& text, const std::vector<Json>& objects);
// Writes the report of --json: one object, or an array when there are several, to standard output or to --json=FILE.
void writeJson(const Options&, const std::vector<Json>& objects);
// Prints a line for people on standard error; a line that cannot be written is lost and ends nothing. say(): nothing with -q.
void tell(const std::string& line);
void say(const Options&, const std::string& line);

}  // namespace plumb
