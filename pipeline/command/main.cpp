// SPDX-License-Identifier: MIT
// Start, catch, exit code.
#include "pipeline/cli/options.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"

#include <fcntl.h>
#include <unistd.h>
#include <cstdio>
#include <new>

namespace {

// Opens closed standard streams. A caller may have closed one. A picture must not then be opened under its number, because it would receive
// what is printed. The number is taken, read-only, and printing fails as it should.
void occupyStandardStreams() {
    for (int fd = 0; fd <= 2; ++fd)
        if (::fcntl(fd, F_GETFD) == -1 && ::open("/dev/null", O_RDONLY) != fd) return;
}

plumb::Exit run(const plumb::Options& options) {
    using namespace plumb;
    if (options.version) return printData(versionReport()), Exit::done;
    if (options.help) return printData(options.command == kHelp ? usageText() : helpText(options.command)), Exit::done;
    switch (options.command) {
        case kRender:
            return renderCommand(options);
        case kVerify:
            return verifyCommand(options);
        case kReplay:
            return replayCommand(options);
        case kDiff:
            return diffCommand(options);
        case kMeasure:
            return measureCommand(options);
        case kPlan:
            return planCommand(options);
        case kDevices:
            return devicesCommand(options);
        case kInfo:
            return infoCommand(options);
        case kMatrix:
            return matrixCommand(options);
        case kBench:
            return benchCommand(options);
        case kPixel:
            return pixelCommand(options);
        case kStress:
            return stressCommand(options);
        default:
            return helpCommand(options);
    }
}

int fail(plumb::Exit exit, const char* message) {
    std::fprintf(stderr, "plumb: %s\n", message);
    return int(exit);
}

// True when a command writes files. Its report then is a part of the result: a reader that leaves is a failure. A text alone is cut where
// its reader has had enough.
bool makesFiles(const plumb::Options& options) {
    return !options.output.empty() || !options.heat.empty() || !options.jsonFile.empty() || !options.csvFile.empty() ||
           !options.junit.empty() || !options.capsule.empty();
}

}  // namespace

int main(int count, char** arguments) {
    occupyStandardStreams();
    plumb::catchInterrupts();
    plumb::Options options;
    try {
        options = plumb::parseOptions({arguments + (count > 0 ? 1 : 0), arguments + count});
        return int(run(options));
    } catch (const plumb::Error& error) {
        // Exit code of the signal: a renderer that was interrupted does not know which one it was.
        if (error.exit() == plumb::Exit::interrupted && plumb::interruptedBy() != 0)
            return fail(plumb::Exit(128 + plumb::interruptedBy()), error.what());
        if (error.exit() == plumb::kReaderLeft) return makesFiles(options) ? fail(plumb::Exit::failed, error.what()) : int(error.exit());
        return fail(error.exit(), error.what());
    } catch (const std::bad_alloc&) {
        return fail(plumb::Exit::failed, "out of memory");
    } catch (const std::exception& error) {
        return fail(plumb::Exit::failed, error.what());
    }
}
