// estancia compare: scores of methods in tests → which methods differ.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/findings/comparison_findings.hpp"
#include "estancia/findings/findings_page.hpp"
#include "estancia/findings/result_table.hpp"
#include "estancia/findings/score_table.hpp"

namespace estancia::apps {
namespace {

namespace fs = std::filesystem;

struct CompareArguments {
  explicit CompareArguments(CLI::App& command) : declared(command) {}
  std::string scores, output, column = "accuracy", only, without;
  ComparisonOptions options;
  DeclaredOptions declared;
  bool overwrite = false, json = false;
};

using Json = nlohmann::ordered_json;

Json jsonOf(const MethodComparison& comparison) {
  const auto name = [&](std::size_t method) { return comparison.scores.methods[method]; };
  const FriedmanTest& friedman = comparison.friedman;
  Json json{{"tests", comparison.scores.tests},
            {"alpha", comparison.options.alpha},
            {"better", comparison.options.better == Better::larger ? "larger" : "smaller"},
            {"friedman",
             {{"chi_squared", friedman.chiSquared},
              {"degrees", friedman.degrees},
              {"p", friedman.p},
              {"f", friedman.f},
              {"f_degrees", {friedman.fDegrees, friedman.fOtherDegrees}},
              {"f_p", friedman.fP}}},
            {"differ", comparison.differ},
            {"control", name(comparison.control)}};
  if (!friedman.undefined.empty()) json["friedman"]["undefined"] = friedman.undefined;
  if (comparison.criticalDifference) json["critical_difference"] = *comparison.criticalDifference;
  if (comparison.wilcoxon)
    json["wilcoxon"] = {{"p", comparison.wilcoxon->p}, {"exact", comparison.wilcoxon->exact}};
  for (const auto& row : comparison.rows)
    json["methods"].push_back({{"method", name(row.method)},
                               {"p", row.p ? Json(*row.p) : Json()},
                               {"rejected", row.rejected},
                               {"rank", row.meanRank},
                               {"win", row.control.wins},
                               {"tie", row.control.ties},
                               {"loss", row.control.losses}});
  for (const PairTest& pair : comparison.pairs)
    json["pairs"].push_back({{"first", name(pair.first)},
                             {"second", name(pair.second)},
                             {"z", pair.z},
                             {"p", pair.p},
                             {"adjusted", pair.adjusted}});
  return json;
}

void writeAll(const fs::path& folder, const Findings& findings) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw Error(ErrorCode::fileUnwritable,
                fmt::format("cannot make the folder {}: {}; choose another with -o", folder.string(),
                            error.message()));
  writeFindingsFiles(folder / "comparison", findings);
  spdlog::info("wrote comparison.md, .csv, .tex, .html and .svg into {}", folder.string());
}

/// The tests that are asked for, by their names.
void chooseTests(MethodScores& scores, const CompareArguments& arguments) {
  const auto has = [](const std::string& test, const std::string& text) {
    return test.find(text) != std::string::npos;
  };
  MethodScores chosen{scores.methods, {}, {}};
  for (std::size_t t = 0; t < scores.tests.size(); ++t) {
    if (!has(scores.tests[t], arguments.only)) continue;
    if (!arguments.without.empty() && has(scores.tests[t], arguments.without)) continue;
    chosen.tests.push_back(scores.tests[t]);
    chosen.values.push_back(std::move(scores.values[t]));
  }
  if (chosen.tests.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("no test of {} is left by --only and --without; its first is \"{}\"",
                            arguments.scores, scores.tests.front()));
  scores = std::move(chosen);
}

void run(const CompareArguments& arguments) {
  if (!arguments.output.empty() && !arguments.overwrite &&
      fs::exists(fs::path(arguments.output) / "comparison.md"))
    throw Error(ErrorCode::fileExists,
                fmt::format("{} holds a comparison; replace it with --overwrite", arguments.output));
  MethodScores scores = readScores(arguments.scores, arguments.column);
  chooseTests(scores, arguments);
  const auto requireTwo = [&](const std::vector<std::string>& names, const char* what) {
    if (names.size() < 2)
      throw Error(ErrorCode::insufficientData,
                  fmt::format("{} has one {} ({}); a comparison needs at least 2 methods and 2 tests",
                              arguments.scores, what, names.front()));
  };
  requireTwo(scores.methods, "method");
  requireTwo(scores.tests, "test");
  const MethodComparison comparison = compareMethods(std::move(scores), arguments.options);
  const Findings findings = comparisonFindings(comparison);
  if (!arguments.output.empty()) writeAll(arguments.output, findings);
  if (arguments.json) {
    print(jsonOf(comparison));
    return;
  }
  fmt::print("{}\n\n", findings.summary);
  for (const auto& [fact, value] : findings.facts) fmt::print("{}: {}\n", fact, value);
  fmt::print("\n{}", textTable(comparisonTable(comparison)));
  for (const std::string& note : findings.notes) spdlog::warn("{}", note);
}

}  // namespace

void addCompareCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "compare", "Compare methods over several tests: Friedman's test, post-hoc tests, ranks, wins");
  auto arguments = std::make_shared<CompareArguments>(*command);
  command
      ->add_option(
          "SCORES", arguments->scores,
          "CSV: a row a test, its name first, then a column a method; or results.csv of an experiment "
          "on scenes (columns descriptor,classifier,train,test,accuracy: a method is "
          "descriptor/classifier, a test train→test)")
      ->required();
  addOutputOption(*command, arguments->output,
                  "Folder for comparison.md, .csv, .tex (tables), .html (page) and .svg (diagram)")
      ->type_name("FOLDER");
  addOverwriteOption(*command, arguments->overwrite);
  arguments->declared.add(declare(arguments->options), {"post-hoc", "alpha", "control", "better"});
  command->add_option("--score", arguments->column, "The column of an experiment's scores that is compared")
      ->capture_default_str();
  command->add_option("--only", arguments->only, "Only tests with this text in their names")
      ->type_name("TEXT");
  command->add_option("--without", arguments->without, "No tests with this text in their names")
      ->type_name("TEXT");
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia compare accuracies.csv\n"
              "  estancia compare nyu/nyu-scores.csv -o nyu/comparison\n"
              "  estancia compare vidrilo/results.csv --only sequence5 --without sequence5→sequence5\n"
              "  estancia compare errors.csv --better smaller --post-hoc nemenyi --json\n"
              "\n"
              "accuracies.csv:\n"
              "  test,GIST/SVM,ESF/forest,PHOG/kNN\n"
              "  day→day,0.91,0.93,0.71\n"
              "  day→night,0.62,0.70,0.44\n"
              "  night→day,0.66,0.69,0.40");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
