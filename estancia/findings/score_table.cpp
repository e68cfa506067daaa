// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/score_table.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "estancia/core/fail.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"

namespace estancia {
namespace {

/// Names in order of first appearance, as they can be shown.
class Names {
 public:
  std::size_t add(const std::string& text) {
    const std::string name = io::printable(text);
    const auto [at, isNew] = numbers_.emplace(name, names_.size());
    if (isNew) names_.push_back(name);
    return at->second;
  }
  const std::vector<std::string>& list() const { return names_; }

 private:
  std::map<std::string, std::size_t> numbers_;
  std::vector<std::string> names_;
};

/// Reads a table of scores, wide (a column a method) or long (a row a score). Life cycle: the constructor
/// reads the whole file or throws, then dense() may be called. Invariant: `scores_` holds each pair of method
/// and test once, with the line it came from.
class ScoreReader {
 public:
  ScoreReader(const std::filesystem::path& file, std::string score) : file_(file), score_(std::move(score)) {
    io::forEachCsvRow(file, [this](io::CsvRow& row) { head_.empty() ? readHead(row) : readRow(row); });
    if (head_.empty())
      fail(ErrorCode::insufficientData, "{}empty; write a header that names the methods, then scores",
           where(1));
    if (scores_.empty()) fail(ErrorCode::insufficientData, "{}no scores below the header", where(1));
  }

  MethodScores dense() const {
    requireAll();
    MethodScores table{methods_.list(), tests_.list(), {}};
    table.values.assign(tests_.list().size(), std::vector<double>(methods_.list().size()));
    for (const auto& [at, score] : scores_) table.values[at.second][at.first] = score.value;
    return table;
  }

 private:
  struct Score {
    double value;
    std::size_t line;
  };

  std::string where(std::size_t line) const {
    return io::printable(file_.string()) + (line > 1 ? fmt::format(":{}: ", line) : ": ");
  }

  void readHead(const io::CsvRow& row) {
    head_ = row.cells;
    for (const char* name : {"descriptor", "classifier", "train", "test"})
      if (const auto found = io::findColumn(head_, name)) keys_.push_back(*found);
    if (keys_.size() == 4) {
      const auto found = io::findColumn(head_, score_);
      if (!found)
        fail(ErrorCode::unknownName, "{}no column \"{}\"; known: {}", where(row.line), score_,
             fmt::join(head_, ", "));
      scoreColumn_ = *found;
      return;
    }
    keys_.clear();
    for (std::size_t c = 1; c < head_.size(); ++c) {
      if (head_[c].empty())
        fail(ErrorCode::malformedFile, "{}column {} has no name; the header names the methods",
             where(row.line), c + 1);
      if (methods_.add(head_[c]) != c - 1)
        fail(ErrorCode::malformedFile, "{}two columns are named \"{}\"", where(row.line), head_[c]);
    }
    if (head_.size() < 2)
      fail(ErrorCode::malformedFile,
           "{}only one column; write one row per test with one column per method, or the columns "
           "descriptor,classifier,train,test,accuracy",
           where(row.line));
  }

  void readRow(const io::CsvRow& row) {
    if (row.cells.size() != head_.size())
      fail(ErrorCode::malformedFile, "{}{} cells instead of {}", where(row.line), row.cells.size(),
           head_.size());
    const auto& cells = row.cells;
    if (!keys_.empty()) {
      add(row.line, methods_.add(cells[keys_[0]] + "/" + cells[keys_[1]]),
          tests_.add(cells[keys_[2]] + "→" + cells[keys_[3]]), cells[scoreColumn_], head_[scoreColumn_]);
      return;
    }
    const std::size_t before = tests_.list().size();
    if (tests_.add(cells[0]) != before)
      fail(ErrorCode::malformedFile, "{}repeated test \"{}\"", where(row.line), io::printable(cells[0]));
    for (std::size_t c = 1; c < cells.size(); ++c) add(row.line, c - 1, before, cells[c], head_[c]);
  }

  void add(std::size_t line, std::size_t method, std::size_t test, const std::string& text,
           const std::string& columnName) {
    if (text.empty() || text == "–" || text == "-" || text == "n/a" || text == "nan" || text == "NaN") return;
    const auto value = io::toNumber(text);
    if (!value || !std::isfinite(*value))
      fail(ErrorCode::malformedFile, "{}{} is \"{}\", not a finite number", where(line),
           io::printable(columnName), io::printable(text));
    const auto [known, isNew] = scores_.emplace(std::pair(method, test), Score{*value, line});
    if (!isNew)
      fail(ErrorCode::malformedFile, "{}the score of {} in {} is repeated from line {}", where(line),
           methods_.list()[method], tests_.list()[test], known->second.line);
  }

  /// Called before the table is allocated, which may be much larger than the file.
  void requireAll() const {
    const std::size_t methods = methods_.list().size(), tests = tests_.list().size();
    if (scores_.size() / methods == tests && scores_.size() % methods == 0) return;
    constexpr std::size_t maxListed = 5;
    std::vector<std::string> listed;
    for (std::size_t m = 0; m < methods && listed.size() < maxListed; ++m)
      for (std::size_t t = 0; t < tests && listed.size() < maxListed; ++t)
        if (!scores_.contains({m, t}))
          listed.push_back(fmt::format("{} in {}", methods_.list()[m], tests_.list()[t]));
    const double missing =
        static_cast<double>(methods) * static_cast<double>(tests) - static_cast<double>(scores_.size());
    const double more = missing - static_cast<double>(listed.size());
    fail(ErrorCode::insufficientData,
         "{}no score of {}{}; ranks need every method in every test: complete the table, or leave those "
         "methods or tests out",
         where(1), fmt::join(listed, ", of "), more > 0 ? fmt::format(" and {:.0f} more", more) : "");
  }

  std::filesystem::path file_;
  std::string score_;
  std::vector<std::string> head_;
  std::vector<std::size_t> keys_;  // columns of descriptor, classifier, train, test; empty in a wide table
  std::size_t scoreColumn_ = 0;
  Names methods_, tests_;
  std::map<std::pair<std::size_t, std::size_t>, Score> scores_;  // by method and test
};

}  // namespace

MethodScores readScores(const std::filesystem::path& file, const std::string& score) {
  return ScoreReader(file, score).dense();
}

}  // namespace estancia
