// estancia check: what in one's own data would break a map, and how to mend it.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "common.hpp"
#include "estancia/check/check.hpp"
#include "estancia/core/error.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/report/text.hpp"

namespace estancia::apps {
namespace {

using report::counted;

struct CheckArguments {
  explicit CheckArguments(CLI::App& command) : declared(command) {}
  SequenceArguments sequence;
  CheckOptions options;
  DeclaredOptions declared;
  bool json = false;
};

void printForPeople(const CheckReport& report, const std::vector<std::string>& notes) {
  for (const CheckItem& item : report.items) {
    const char* mark = item.severity == Severity::fine      ? "ok"
                       : item.severity == Severity::warning ? "warning"
                                                            : "PROBLEM";
    fmt::print("{:<8} {} ({}){}{}\n", mark, item.what, item.evidence, item.fix.empty() ? "" : " → ",
               item.fix);
  }
  for (const std::string& note : notes) fmt::print("note     {}\n", note);
  fmt::print("{}: {}, {}\n", counted(report.frames, "frame"),
             counted(report.count(Severity::problem), "problem"),
             counted(report.count(Severity::warning), "warning"));
}

void printForMachines(const CheckReport& report, const std::vector<std::string>& notes) {
  const auto severity = [](Severity s) {
    return s == Severity::fine ? "fine" : s == Severity::warning ? "warning" : "problem";
  };
  auto findings = nlohmann::ordered_json::array();
  for (const CheckItem& item : report.items)
    findings.push_back({{"severity", severity(item.severity)},
                        {"name", item.name},
                        {"what", item.what},
                        {"evidence", item.evidence},
                        {"fix", item.fix}});
  print({{"frames", report.frames},
         {"problems", report.count(Severity::problem)},
         {"warnings", report.count(Severity::warning)},
         {"findings", findings},
         {"notes", notes}});
}

void run(const CheckArguments& arguments) {
  if (isDescriptorFile(arguments.sequence.path))
    throw Error(
        ErrorCode::unsupportedFile,
        fmt::format("{} holds labels; check the images they were made from", arguments.sequence.path));
  const auto sequence = arguments.sequence.openQuietly();
  const auto progress = makeStderrProgress();
  const CheckReport report = checkSequence(*sequence, arguments.options, *progress);
  if (arguments.json)
    printForMachines(report, sequence->warnings());
  else
    printForPeople(report, sequence->warnings());
  if (report.count(Severity::problem) > 0) throw NoAnswer();
}

}  // namespace

void addCheckCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("check",
                         "Find faults in your data that would spoil a map (poses, depth, stamps …), and how "
                         "to repair them; exit code 1 when there are some");
  auto arguments = std::make_shared<CheckArguments>(*command);
  arguments->sequence.addTo(arguments->declared);
  arguments->sequence.addDepthTo(arguments->declared);
  arguments->declared.add(declare(arguments->options), {"max-frames"});
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia check ~/recording\n"
              "  estancia check ~/recording --poses slam.txt --intrinsics camera.yaml --depth-scale 5000");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
