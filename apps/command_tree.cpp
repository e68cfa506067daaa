// SPDX-License-Identifier: Apache-2.0
#include "command_tree.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

#include "command_line.hpp"
#include "declared_options.hpp"
#include "estancia/version.hpp"

namespace estancia::apps {
namespace {

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

std::vector<const CLI::App*> subcommandsOf(const CLI::App& app) {
  std::vector<const CLI::App*> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (!command->get_name().empty()) commands.push_back(command);
  return commands;
}

std::vector<const CLI::Option*> optionsOf(const CLI::App& app, bool positional) {
  std::vector<const CLI::Option*> options;
  for (const CLI::Option* option : app.get_options())
    if (option->get_positional() == positional) options.push_back(option);
  return options;
}

/// Lists entries of the help in indented lines: "  NAME" or "  NAME: description".
std::vector<std::string> valuesOf(const CLI::Option& option) {
  std::vector<std::string> values;
  std::istringstream lines(option.get_description());
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("  ")) values.push_back(line.substr(2, line.find(':') - 2));
  return values;
}

/// "-o,--output FILE"
std::string signatureOf(const CLI::Option& option) {
  std::string text = option.get_positional() ? option.get_name(true) : option.get_name(false, true);
  if (!option.get_positional() && takesValue(option)) text += " " + option.get_type_name();
  return text;
}

std::string firstLine(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

std::string usageOf(const std::string& name, const CLI::App& command) {
  std::string usage = name + " [OPTIONS]";
  for (const CLI::Option* option : optionsOf(command, true))
    usage += option->get_required() ? " " + option->get_name(true) : " [" + option->get_name(true) + "]";
  if (!subcommandsOf(command).empty()) usage += " COMMAND";
  return usage;
}

std::string roff(std::string text) {
  text = replaced(std::move(text), "\\", "\\e");
  text = replaced(std::move(text), "-", "\\-");
  std::string safe;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    const std::string line = text.substr(start, end - start);
    if (!line.empty() && (line[0] == '.' || line[0] == '\'')) safe += "\\&";
    safe += line;
    if (end < text.size()) safe += "\n.br\n";
    start = end + 1;
  }
  return safe;
}

/// For single quotes of the shell, inside of _arguments' brackets.
std::string zshText(const std::string& text) {
  std::string safe;
  for (const char c : firstLine(text)) {
    if (c == '\'')
      safe += "'\\''";
    else if (c == '[' || c == ']' || c == ':')
      safe += std::string("\\") + c;
    else
      safe += c;
  }
  return safe;
}

/// A name for a function of the shell.
std::string functionOf(const std::string& name) {
  return "_" + replaced(replaced(name, " ", "_"), "-", "_");
}

void addOptionRows(std::string& text, const PublishedGroup& published, const OptionGroup& group,
                   const std::string& path) {
  const auto cell = [](const std::string& content) {
    return replaced(replaced(content, "|", "\\|"), "\n", " ");
  };
  for (const Option& option : group.options()) {
    const std::string value = option.automatic().empty() ? option.text() : option.automatic();
    const auto flags = published.flagsOf(path + option.name());
    text += fmt::format("| `{}{}` | {} | {} | {} | {} {} |\n", path, option.name(),
                        flags.empty() ? "" : fmt::format("`{}`", fmt::join(flags, "`, `")),
                        cell(value.empty() ? "none" : value), cell(option.accepted()), cell(option.help()),
                        cell(option.why()));
  }
  for (const OptionGroup& inner : group.groups())
    addOptionRows(text, published, inner, path + inner.name() + ".");
}

}  // namespace

std::vector<std::pair<std::string, const CLI::App*>> commandsOf(const CLI::App& app) {
  std::vector<std::pair<std::string, const CLI::App*>> commands{{app.get_name(), &app}};
  for (const CLI::App* command : subcommandsOf(app))
    for (const auto& [name, inner] : commandsOf(*command))
      commands.emplace_back(app.get_name() + " " + name, inner);
  return commands;
}

std::string bashCompletion(const CLI::App& app) {
  std::string cases, values;
  for (const auto& [name, command] : commandsOf(app)) {
    std::vector<std::string> words;
    for (const CLI::App* inner : subcommandsOf(*command)) words.push_back(inner->get_name());
    for (const CLI::Option* option : optionsOf(*command, false))
      for (const std::string& word : option->get_lnames()) {
        words.push_back("--" + word);
        if (const auto known = valuesOf(*option); !known.empty())
          values += fmt::format("    '{} --{}') words='{}' files= ;;\n", name, word, fmt::join(known, " "));
      }
    cases += fmt::format("    '{}') words='{}' files={} ;;\n", name, fmt::join(words, " "),
                         subcommandsOf(*command).empty() ? "yes" : "");
  }
  return fmt::format(
      "# bash completion of estancia {}\n"
      "_estancia() {{\n"
      "  local word command={} words files next i\n"
      "  word=${{COMP_WORDS[COMP_CWORD]}}\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    next=\"$command ${{COMP_WORDS[i]}}\"\n"
      "    case $next in\n{}"
      "      *) continue ;;\n"
      "    esac\n"
      "    command=$next\n"
      "  done\n"
      "  case $command in\n{}  esac\n"
      "  case \"$command ${{COMP_WORDS[COMP_CWORD - 1]}}\" in\n{}  esac\n"
      "  if [[ $word == -* ]]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
      "  else\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"${{words//--+([^ ])/}}\" -- \"$word\"; [[ -z $files ]] || "
      "compgen -f -- \"$word\")\n"
      "  fi\n"
      "}}\n"
      "shopt -s extglob\n"
      "complete -o filenames -F _estancia estancia\n",
      version(), app.get_name(),
      [&] {
        std::vector<std::string> names;
        for (const auto& [name, command] : commandsOf(app)) names.push_back("'" + name + "'");
        return fmt::format("      {}) ;;\n", fmt::join(names, " | "));
      }(),
      cases, values);
}

std::string zshCompletion(const CLI::App& app) {
  std::string script = "#compdef estancia\n";
  for (const auto& [name, command] : commandsOf(app)) {
    script += fmt::format("{}() {{\n  _arguments -C \\\n", functionOf(name));
    for (const CLI::Option* option : optionsOf(*command, false))
      for (const std::string& word : option->get_lnames())
        script += fmt::format("    '--{}{}[{}]{}' \\\n", word, takesValue(*option) ? "=" : "",
                              zshText(option->get_description()),
                              !takesValue(*option) ? ""
                              : valuesOf(*option).empty()
                                  ? ":value:_files"
                                  : fmt::format(":value:({})", fmt::join(valuesOf(*option), " ")));
    const auto inner = subcommandsOf(*command);
    if (inner.empty()) {
      script += "    '*:file:_files'\n}\n";
      continue;
    }
    script +=
        "    '1: :->command' '*:: :->rest'\n  case $state in\n    command)\n      local -a commands=(\n";
    for (const CLI::App* one : inner)
      script += fmt::format("        '{}:{}'\n", one->get_name(), zshText(one->get_description()));
    script += "      )\n      _describe command commands ;;\n    rest)\n      case $words[1] in\n";
    for (const CLI::App* one : inner)
      script += fmt::format("        {}) {} ;;\n", one->get_name(), functionOf(name + " " + one->get_name()));
    script += "      esac ;;\n  esac\n}\n";
  }
  return script + functionOf(app.get_name()) + " \"$@\"\n";
}

std::string manPage(const std::string& name, const CLI::App& command) {
  const std::string title = replaced(name, " ", "-");
  std::string page = fmt::format(".TH {} 1 \"\" \"Estancia {}\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n.B {}\n",
                                 roff(title), version(), roff(title),
                                 roff(firstLine(command.get_description())), roff(usageOf(name, command)));
  const auto list = [&page](const char* heading, const std::vector<const CLI::Option*>& options) {
    if (options.empty()) return;
    page += fmt::format(".SH {}\n", heading);
    for (const CLI::Option* option : options)
      page += fmt::format(".TP\n.B {}\n{}\n", roff(signatureOf(*option)), roff(option->get_description()));
  };
  list("ARGUMENTS", optionsOf(command, true));
  list("OPTIONS", optionsOf(command, false));
  if (const auto inner = subcommandsOf(command); !inner.empty()) {
    page += ".SH COMMANDS\n";
    for (const CLI::App* one : inner)
      page += fmt::format(".TP\n.BR {}\\-{} (1)\n{}\n", roff(title), roff(one->get_name()),
                          roff(one->get_description()));
  }
  page += ".SH EXIT STATUS\n0: success. 1: the question has no answer. 2: an error. 130: interrupted.\n";
  if (!command.get_footer().empty())
    page += fmt::format(".SH EXAMPLES\n.nf\n{}\n.fi\n",
                        roff(command.get_footer().substr(command.get_footer().find('\n') + 1)));
  return page;
}

std::string commandReference(const CLI::App& app) {
  std::string text =
      "# Reference: the command\n\nGenerated by `script/reference`; do not edit. Every command has `--help`, "
      "and most "
      "have `--json`.\nThe exit code is 0, 1 when a question has no answer, 2 on an error, 130 after "
      "Ctrl-C.\n";
  for (const auto& [name, command] : commandsOf(app)) {
    text +=
        fmt::format("\n## {}\n\n{}\n\n    {}\n", name, command->get_description(), usageOf(name, *command));
    if (const auto inner = subcommandsOf(*command); !inner.empty()) {
      text += "\n";
      for (const CLI::App* one : inner)
        text += fmt::format("* `{} {}`: {}\n", name, one->get_name(), one->get_description());
    }
    const bool isGroup = !subcommandsOf(*command).empty();
    for (const bool positional : {true, false})
      for (const CLI::Option* option :
           isGroup ? std::vector<const CLI::Option*>() : optionsOf(*command, positional)) {
        if (option->get_name(false, true) == "-h,--help") continue;
        if (positional || option == optionsOf(*command, false).front()) text += "\n";
        text += fmt::format("* `{}`: {}\n", signatureOf(*option),
                            replaced(replaced(option->get_description(), "\n  ", "\n"), "\n", "\n  * "));
      }
    if (!command->get_footer().empty()) {
      const std::string examples = command->get_footer().substr(command->get_footer().find('\n') + 1);
      text += fmt::format("\n```sh\n{}\n```\n",
                          replaced(replaced(examples, "\n  ", "\n"), "  estancia", "estancia"));
    }
  }
  return text;
}

std::string optionReference() {
  std::string text =
      "# Reference: parameters\n\nGenerated by `script/reference`; do not edit. Every parameter can be set "
      "by `--set "
      "GROUP.NAME=VALUE`, or in a\nTOML file given by `--config`, in a table of the group's name with "
      "underscores for "
      "dashes. C++ programs set the\nmember of the same name.\n";
  for (const PublishedGroup& published : publishedGroups()) {
    text += fmt::format(
        "\n## {}\n\n{} Used by `{}`.\n\n"
        "| parameter | flag | default | accepts | meaning, and why to change it |\n"
        "| --- | --- | --- | --- | --- |\n",
        published.group.name(), published.group.help(), fmt::join(published.commands, "`, `"));
    addOptionRows(text, published, published.group, "");
  }
  return text;
}

}  // namespace estancia::apps
