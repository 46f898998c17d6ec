// SPDX-License-Identifier: MIT
#include "pipeline/command/interrupt.h"

#include "host/error.h"
#include "pipeline/image/image.h"

#include <unistd.h>
#include <csignal>

namespace plumb {
namespace {

volatile std::sig_atomic_t caught = 0;

extern "C" void onSignal(int signal) {
    if (caught != 0) {  // second signal: no destructor runs, so the temporary file is removed here
        removeTemporaryFile();
        ::_exit(128 + signal);
    }
    caught = signal;
}

}  // namespace

void catchInterrupts() {
    struct sigaction action {};
    action.sa_handler = onSignal;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    for (const int signal : {SIGINT, SIGTERM}) {
        struct sigaction before {};
        ::sigaction(signal, nullptr, &before);
        if (before.sa_handler != SIG_IGN) ::sigaction(signal, &action, nullptr);  // nohup and background jobs keep theirs
    }
    std::signal(SIGPIPE, SIG_IGN);  // a reader that left is a failed write, with a message and exit 5
    std::signal(SIGXFSZ, SIG_IGN);  // so is a file size limit
}

int interruptedBy() { return caught; }

void stopIfInterrupted() {
    if (caught == SIGTERM) throw Error(Exit::terminated, "terminated");
    if (caught != 0) throw Error(Exit::interrupted, "interrupted");
}

}  // namespace plumb
