// SPDX-License-Identifier: MIT
// Output of the program: data on standard output, messages on standard error, reports as JSON, and the tool's version.
#include "pipeline/command/command.h"
#include "pipeline/command/version.h"
#include "pipeline/image/file_batch.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <unistd.h>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace plumb {

namespace {

[[noreturn]] void refuseOutput(int error) {
    const std::string message = fmt::format("cannot write standard output: {}", std::strerror(error));
    throw error == EPIPE ? Error(kReaderLeft, message) : renderError(message);
}

bool toStandardOutput(const Options& options) { return options.json && options.jsonFile.empty(); }

}  // namespace

void printData(const std::string& text) {
    for (size_t done = 0; done < text.size();) {
        const ssize_t n = ::write(STDOUT_FILENO, text.data() + done, text.size() - done);
        if (n < 0 && errno != EINTR) refuseOutput(errno);
        if (n > 0) done += size_t(n);
    }
}

void expectReader() {
    const int mode = ::fcntl(STDOUT_FILENO, F_GETFL);
    if (mode < 0 || (mode & O_ACCMODE) == O_RDONLY) refuseOutput(EBADF);  // closed by the caller: main() has put /dev/null there
    pollfd output{STDOUT_FILENO, POLLOUT, 0};
    if (::poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0) refuseOutput(EPIPE);
}

void finish(const Options& options, FileBatch& files, const std::string& text, const std::vector<Json>& objects) {
    std::string json;
    if (options.json)  // paths may hold bytes that are not UTF-8; JSON may not
        json = (objects.size() == 1 ? objects[0] : Json(objects)).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    if (options.json && !options.jsonFile.empty()) files.add(options.jsonFile, std::as_bytes(std::span(json)), options.noClobber);
    files.place();
    printData(text);
    if (toStandardOutput(options)) printData(json);
    files.keep();
}

void writeJson(const Options& options, const std::vector<Json>& objects) {
    FileBatch file;
    finish(options, file, "", objects);
}

// Prints a message. fmt::print throws when standard error is full, closed or has no reader, but messages never end a run.
void tell(const std::string& line) {
    const std::string text = line + "\n";
    std::fwrite(text.data(), 1, text.size(), stderr);
}

void say(const Options& options, const std::string& line) {
    if (!options.quiet) tell(line);
}

Json toolJson() {
    Json modules = Json::object();
    for (const auto& [name, sha256] : spirvModules()) modules[std::string(name)] = sha256;
    return {{"version", versionText()}, {"git", gitRevision()}, {"spirv", modules}};
}

std::string versionReport() {
    std::string text = fmt::format("plumb {} ({})\n", versionText(), gitRevision());
    for (const auto& [name, sha256] : spirvModules()) text += fmt::format("  {:<16} {}\n", name, sha256);
    return text;
}

Exit helpCommand(const Options& options) {
    if (options.man)
        printData(manPage());
    else if (!options.completion.empty())
        printData(completionScript(options.completion));
    else if (options.inputs.empty())
        printData(usageText());
    else
        for (const CommandRow& row : commands())
            if (options.inputs[0] == row.name) printData(helpText(row.bit));
    return Exit::done;
}

}  // namespace plumb
