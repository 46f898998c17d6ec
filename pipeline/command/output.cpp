// SPDX-License-Identifier: MIT
// What leaves the program: data on standard output, words on standard error, reports as JSON, and what the tool is.
#include "pipeline/command/command.h"
#include "pipeline/command/version.h"
#include "pipeline/image/image.h"

#include <cstdio>
#include <fmt/core.h>
#include <span>
#include <string>
#include <vector>

namespace plumb {

void printData(const std::string& text) { writeFileAtomically("-", std::as_bytes(std::span(text)), false); }

void writeJson(const Options& options, const std::vector<Json>& objects) {
    if (!options.json) return;
    const Json json = objects.size() == 1 ? objects[0] : Json(objects);
    // Paths may hold bytes that are not UTF-8; JSON may not.
    const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    if (options.jsonFile.empty())
        printData(text);
    else
        writeFileAtomically(options.jsonFile, std::as_bytes(std::span(text)), options.noClobber);
}

// fmt::print throws when standard error is full, closed or has no reader. Words for people never end a run.
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
