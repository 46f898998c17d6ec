// SPDX-License-Identifier: MIT
// Help, man page and completions, all from the table of flags.
#include "host/error.h"
#include "pipeline/cli/options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <cstddef>
#include <string>
#include <vector>

namespace plumb {
namespace {

constexpr size_t kColumns = 100;

// `text` in lines of at most kColumns, the second and later ones indented.
std::string wrapped(const std::string& text, size_t indent) {
    std::string out;
    size_t column = indent, at = 0;
    while (at < text.size()) {
        size_t end = text.find(' ', at);
        if (end == text.npos) end = text.size();
        const std::string word = text.substr(at, end - at);
        if (column > indent && column + 1 + word.size() > kColumns) {
            out += fmt::format("\n{:{}}", "", indent);
            column = indent;
        } else if (column > indent) {
            out += ' ';
            ++column;
        }
        out += word;
        column += word.size();
        at = end + 1;
    }
    return out;
}

std::string signature(const Flag& flag) {
    const std::string brief = flag.shortName();
    return fmt::format("{}{}{}{}{}", brief, brief.empty() ? "    " : ", ", flag.longName(),
                       flag.isSwitch() || flag.optionalValue() ? "" : " ", flag.argument);
}

void add(std::string& list, const char* separator, const std::string& word) {
    if (!list.empty()) list += separator;
    list += word;
}

bool belongs(const Flag& flag, Command command) { return (flag.commands & command) != 0 && !flag.hidden; }

// Accepted values add to the sentence unless they only repeat the argument's name.
std::string explanation(const Flag& flag) {
    std::string text = flag.help;
    if (!flag.meanings.empty())
        text += fmt::format(": {}", flag.meanings);
    else if (!flag.accepted.empty() && flag.accepted != "a path" && flag.longName() != "--output")
        text += fmt::format("; {}", flag.accepted);
    if (flag.fallback[0] != '\0') text += fmt::format(" [{}]", flag.fallback);
    return text;
}

std::string exitText() {
    std::string text;
    for (const ExitRow& row : exitCodes()) text += fmt::format("  {:>3}  {}\n", row.code, row.meaning);
    return text;
}

std::string roff(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '\\') {
            out += "\\e";
        } else if (c == '-') {
            out += "\\-";
        } else if (c == '\'') {
            out += "\\(aq";
        } else if (c == '.' && out.empty()) {
            out += "\\&.";
        } else {
            out += c;
        }
    }
    return out;
}

// In single quotes, for bash, zsh and fish alike.
std::string quoted(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '\'')
            out += "'\\''";
        else
            out += c;
    }
    return fmt::format("'{}'", out);
}

std::string joined(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, " ")); }
bool isFile(const Flag& flag) { return flag.words.size() == 1 && flag.words[0] == "FILE"; }

std::string commandNames() {
    std::string names;
    for (const CommandRow& row : commands()) add(names, " ", row.name);
    return names;
}

std::string bashScript() {
    std::string names, alternatives, cases, values;
    for (const CommandRow& row : commands()) {
        add(names, " ", row.name);
        add(alternatives, "|", row.name);
        std::string list;
        for (const Flag& flag : flags())
            if (belongs(flag, row.bit)) add(list, " ", flag.longName());
        cases += fmt::format("        {}) flags=\"{}\" ;;\n", row.name, list);
    }
    for (const Flag& flag : flags()) {
        if (flag.hidden || flag.isSwitch() || flag.optionalValue()) continue;
        const std::string pattern = fmt::format("{}{}{}", flag.shortName(), flag.shortName().empty() ? "" : "|", flag.longName());
        if (isFile(flag))
            values += fmt::format("        {}) COMPREPLY=($(compgen -f -- \"$word\")); return ;;\n", pattern);
        else if (flag.words.empty())
            values += fmt::format("        {}) return ;;\n", pattern);
        else
            values +=
                fmt::format("        {}) COMPREPLY=($(compgen -W {} -- \"$word\")); return ;;\n", pattern, quoted(joined(flag.words)));
    }
    return fmt::format(R"(# bash completion for plumb; made by `plumb help --completion bash`
_plumb() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} command= flags= i
    COMPREPLY=()
    for ((i = 1; i < COMP_CWORD; ++i)); do
        case ${{COMP_WORDS[i]}} in {}) command=${{COMP_WORDS[i]}}; break ;; esac
    done
    case $before in
{}    esac
    if [[ -z $command ]]; then
        COMPREPLY=($(compgen -W {} -- "$word"))
        return
    fi
    case $command in
{}    esac
    if [[ $word == -* ]]; then
        COMPREPLY=($(compgen -W "$flags" -- "$word"))
    elif [[ $command == help ]]; then
        COMPREPLY=($(compgen -W {} -- "$word"))
    else
        COMPREPLY=($(compgen -f -- "$word"))
    fi
}}
complete -o filenames -F _plumb plumb
)",
                       alternatives, values, quoted(names), cases, quoted(names));
}

std::string zshScript() {
    const auto text = [](const std::string& help) {  // brackets and colons end a description of _arguments
        std::string out;
        for (const char c : help) {
            if (c == '[' || c == ']' || c == ':') out += '\\';
            out += c;
        }
        return out;
    };
    std::string names, cases;
    for (const CommandRow& row : commands()) {
        names += fmt::format("        {}\n", quoted(fmt::format("{}:{}", row.name, row.summary)));
        cases += fmt::format("        {})\n            _arguments -s", row.name);
        for (const Flag& flag : flags()) {
            if (!belongs(flag, row.bit)) continue;
            const std::string action = flag.isSwitch()      ? ""
                                       : isFile(flag)       ? fmt::format(":{}:_files", "file")
                                       : flag.words.empty() ? fmt::format(":{}: ", "value")
                                                            : fmt::format(":{}:({})", "value", joined(flag.words));
            const std::string repeat = flag.repeatable ? "*" : "";
            for (const std::string& name : {flag.shortName(), flag.longName()}) {
                if (name.empty()) continue;
                const bool isLong = name.size() > 2;
                const std::string equals = isLong ? (flag.optionalValue() ? "=-" : flag.isSwitch() ? "" : "=") : "";
                const std::string colon = fmt::format("{}{}", flag.optionalValue() && !action.empty() ? ":" : "", action);
                cases += fmt::format(" \\\n                {}",
                                     quoted(fmt::format("{}{}{}[{}]{}", repeat, name, equals, text(flag.help), colon)));
            }
        }
        cases += row.bit == kHelp          ? fmt::format(" \\\n                '1:command:({})'\n            ;;\n", commandNames())
                 : row.operands[0] == '\0' ? "\n            ;;\n"
                                           : " \\\n                '*:file:_files'\n            ;;\n";
    }
    return fmt::format(R"(#compdef plumb
# zsh completion for plumb; made by `plumb help --completion zsh`
_plumb() {{
    local -a names
    names=(
{}    )
    if (( CURRENT == 2 )); then
        _describe command names
        return
    fi
    local command=$words[2]
    shift words
    (( CURRENT-- ))
    case $command in
{}    esac
}}
_plumb "$@"
)",
                       names, cases);
}

std::string fishScript() {
    std::string names, lines;
    for (const CommandRow& row : commands()) {
        add(names, " ", row.name);
        lines += fmt::format("complete -c plumb -f -n __fish_use_subcommand -a {} -d {}\n", row.name, quoted(row.summary));
    }
    for (const Flag& flag : flags()) {
        if (flag.hidden) continue;
        std::string of;
        for (const CommandRow& row : commands())
            if (belongs(flag, row.bit)) add(of, " ", row.name);
        std::string line = fmt::format("complete -c plumb -n '__fish_seen_subcommand_from {}' -l {}", of, flag.longName().substr(2));
        if (!flag.shortName().empty()) line += fmt::format(" -s {}", flag.shortName().substr(1));
        if (!flag.isSwitch() && !flag.optionalValue())
            line += isFile(flag) ? " -r -F" : flag.words.empty() ? " -x" : fmt::format(" -x -a {}", quoted(joined(flag.words)));
        lines += fmt::format("{} -d {}\n", line, quoted(flag.help));
    }
    lines += fmt::format("complete -c plumb -f -n '__fish_seen_subcommand_from help' -a {}\n", quoted(names));
    return fmt::format("# fish completion for plumb; made by `plumb help --completion fish`\n{}", lines);
}

}  // namespace

std::string usageText() {
    std::string text = fmt::format(
        "plumb {}: a Vulkan compute renderer that knows how wrong it is\n\nusage: plumb COMMAND [FLAGS] [FILES]\n\n", versionText());
    for (const CommandRow& row : commands()) text += fmt::format("  {:<8} {:<22} {}\n", row.name, row.operands, row.summary);
    return text +
           "\n`plumb help COMMAND` lists its flags with examples. The order of flags never matters.\nData goes to standard output, "
           "everything else to standard error.\n";
}

std::string helpText(Command command) {
    const CommandRow& row = rowOf(command);
    std::string text = fmt::format("usage: plumb {}{}{} [FLAGS]\n\n{}\n\nflags:\n", row.name, row.operands[0] == '\0' ? "" : " ",
                                   row.operands, wrapped(row.description, 0));
    constexpr size_t kIndent = 28;
    for (const Flag& flag : flags()) {
        if (!belongs(flag, command)) continue;
        const std::string left = fmt::format("  {}", signature(flag));
        text += left.size() + 1 < kIndent ? fmt::format("{:<{}}", left, kIndent) : fmt::format("{}\n{:{}}", left, "", kIndent);
        text += wrapped(explanation(flag), kIndent) + "\n";
    }
    text += "\nexamples:\n";
    for (const auto& [line, what] : row.examples) text += fmt::format("  {}\n      {}\n", line, what);
    return fmt::format("{}\nexit codes:\n{}", text, exitText());
}

std::string manPage() {
    std::string text = fmt::format(
        ".TH PLUMB 1 \"\" \"plumb {}\" \"Plumbline\"\n.SH NAME\nplumb \\- a Vulkan compute renderer that knows how wrong it is\n.SH "
        "SYNOPSIS\n",
        roff(versionText()));
    for (const CommandRow& row : commands())
        text += fmt::format(".B plumb {}\n{}[\\fIFLAGS\\fR]\n.br\n", row.name,
                            row.operands[0] == '\0' ? "" : fmt::format("\\fI{}\\fR ", roff(row.operands)));
    text +=
        ".SH DESCRIPTION\nPlumb draws meshes and scenes by Vulkan compute shaders, on lavapipe where there is no GPU, and checks them "
        "against its CPU twin.\n"
        "The order of flags never matters. Data goes to standard output, everything else to standard error.\n"
        "Files are written to a temporary name in the same folder, synced, then renamed.\n.SH COMMANDS\n";
    for (const CommandRow& row : commands()) text += fmt::format(".TP\n.B {}\n{}\n", row.name, roff(row.description));
    text += ".SH FLAGS\n";
    for (const Flag& flag : flags()) {
        if (flag.hidden) continue;
        std::string of;
        if (flag.commands != kEveryCommand)
            for (const CommandRow& row : commands())
                if (belongs(flag, row.bit)) add(of, ", ", row.name);
        std::string names = fmt::format("{}{}{}", flag.shortName(), flag.shortName().empty() ? "" : ", ", flag.longName());
        std::string argument = flag.isSwitch()        ? ""
                               : flag.optionalValue() ? roff(flag.argument)
                                                      : fmt::format(" \\fI{}\\fR", roff(flag.argument));
        text += fmt::format(".TP\n\\fB{}\\fR{}\n{}.{}\n", roff(names), argument, roff(explanation(flag)),
                            of.empty() ? "" : fmt::format(" ({})", of));
    }
    text += ".SH EXIT STATUS\n";
    for (const ExitRow& row : exitCodes()) text += fmt::format(".TP\n.B {}\n{}\n", row.code, roff(row.meaning));
    text +=
        ".SH ENVIRONMENT\n.TP\n.B VK_ICD_FILENAMES, VK_DRIVER_FILES\nRead by the Vulkan loader: which drivers it may use.\n"
        ".TP\n.B XDG_CACHE_HOME\nWhere the result of the start\\-up self\\-test is kept.\n"
        ".TP\n.B PLUMB_VALIDATION\nWhen set to 1, the validation layers are switched on, and a message of theirs ends the run with exit "
        "code 5.\n.SH EXAMPLES\n";
    for (const CommandRow& row : commands())
        for (const auto& [line, what] : row.examples) text += fmt::format(".TP\n.B {}\n{}\n", roff(line), roff(what));
    return text;
}

std::string completionScript(const std::string& shell) {
    if (shell == "bash") return bashScript();
    if (shell == "zsh") return zshScript();
    PLUMB_ASSERT(shell == "fish");
    return fishScript();
}

}  // namespace plumb
