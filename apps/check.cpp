// estancia check: what in one's own data would break a map, and how to mend it.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <optional>

#include "common.hpp"
#include "estancia/check/check.hpp"
#include "estancia/core/error.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/readers/bag_topics.hpp"
#include "estancia/ros/bag.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"

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

void printTopics(const BagSummary& bag) {
  fmt::print("{:<44} {:<32} {:>8} {:>8} {:>9}  use\n", "topic", "type", "messages", "Hz", "gap [s]");
  for (const TopicSummary& topic : bag.topics) {
    const std::string use = topic.use.empty()   ? topic.why
                            : topic.why.empty() ? topic.use
                                                : fmt::format("{}: {}", topic.use, topic.why);
    fmt::print("{:<44} {:<32} {:>8} {:>8.1f} {:>9.2f}  {}\n", topic.name, topic.type, topic.messages,
               topic.rate, topic.longestGap, use);
  }
  fmt::print("{:.1f} s\n", bag.duration);
}

nlohmann::ordered_json toJson(const BagSummary& bag) {
  auto topics = nlohmann::ordered_json::array();
  for (const TopicSummary& topic : bag.topics)
    topics.push_back({{"name", topic.name},
                      {"type", topic.type},
                      {"messages", topic.messages},
                      {"rate", topic.rate},
                      {"longest_gap", topic.longestGap},
                      {"use", topic.use},
                      {"why", topic.why}});
  return {{"duration", bag.duration}, {"topics", std::move(topics)}};
}

void printForMachines(const CheckReport& report, const std::vector<std::string>& notes,
                      const std::optional<BagSummary>& bag) {
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
  nlohmann::ordered_json json{{"frames", report.frames},
                              {"problems", report.count(Severity::problem)},
                              {"warnings", report.count(Severity::warning)},
                              {"findings", findings},
                              {"notes", notes}};
  if (bag) json["bag"] = toJson(*bag);
  print(json);
}

void run(const CheckArguments& arguments) {
  if (isDescriptorFile(arguments.sequence.path))
    throw Error(
        ErrorCode::unsupportedFile,
        fmt::format("{} holds labels; check the images they were made from", arguments.sequence.path));
  std::optional<BagSummary> bag;
  if (ros::isBag(arguments.sequence.path))
    bag = summarizeBag(arguments.sequence.path, arguments.sequence.options);
  if (bag && !arguments.json) printTopics(*bag);
  const auto sequence = arguments.sequence.openQuietly();
  const auto progress = makeStderrProgress();
  const CheckReport report = checkSequence(*sequence, arguments.options, *progress);
  if (arguments.json)
    printForMachines(report, sequence->warnings(), bag);
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
              "  estancia check drive.mcap\n"
              "  estancia check ~/recording --poses slam.txt --intrinsics camera.yaml --depth-scale 5000");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
