// SPDX-License-Identifier: MIT
// Errors. One exception type knows the exit code of the command. It is thrown where the fault is found and caught in main, and in the
// few kinds of code that decision 114 lists.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <utility>

namespace plumb {

// Exit codes of the command `plumb`; fixed, documented in docs/outputs.md.
enum class Exit : int {
    done = 0,
    overGate = 1,  // compared, and over a gate
    usage = 2,     // command line
    input = 3,     // refused input
    device = 4,    // no usable or no required device
    failed = 5,    // render or write failed: memory, watchdog, lost device, disk
    budget = 6,    // error or time budget unreachable
    blank = 7,     // picture is blank and --fail-blank was given
    interrupted = 130,
    terminated = 143,
};

class Error : public std::runtime_error {
public:
    Error(Exit exit, const std::string& message) : std::runtime_error(message), exit_(exit) {}
    Exit exit() const { return exit_; }

private:
    Exit exit_;
};

// Error of a shader whose loops took more steps than the device gives an invocation (lavapipe: 65,535). The caller may cut the work
// smaller.
class LoopBudgetError : public Error {
public:
    explicit LoopBudgetError(const std::string& message) : Error(Exit::failed, message) {}
};

// Error of refused user input: `location` is "file:line:column", "file: byte N" or "file: /json/pointer".
inline Error inputError(const std::string& location, const std::string& message) { return Error(Exit::input, location + ": " + message); }
inline Error usageError(const std::string& message) { return Error(Exit::usage, message); }
inline Error deviceError(const std::string& message) { return Error(Exit::device, message); }
inline Error renderError(const std::string& message) { return Error(Exit::failed, message); }

// Failure of our own: stays on in every build, prints and aborts.
[[noreturn]] inline void assertionFailed(const char* condition, const char* file, int line) {
    std::fprintf(stderr, "plumb: internal error: %s is false at %s:%d\n", condition, file, line);
    std::abort();
}
#define PLUMB_ASSERT(condition) ((condition) ? void(0) : ::plumb::assertionFailed(#condition, __FILE__, __LINE__))

}  // namespace plumb
