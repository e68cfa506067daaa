// SPDX-License-Identifier: Apache-2.0
#include "words/word_queries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <string_view>

#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/files/files.hpp"
#include "findings/csv_table.hpp"

namespace estancia::experiments {
namespace {

constexpr std::size_t imageNetClasses = 1000;

/// Labels by the ways in which a file of queries names them.
class NamedLabels {
 public:
  explicit NamedLabels(const Vocabulary& vocabulary) : labels_(vocabulary.size()) {
    for (std::size_t label = 0; label < labels_; ++label)
      byName_[shortLabel(vocabulary[label])].push_back(label);
  }

  /// What one item of a list names. Throws Error at the row.
  std::vector<std::size_t> of(std::string_view item, const CsvTable& table, const io::CsvRow& row) const {
    if (item.starts_with('#')) return range(item, table, row);
    const std::string name(item);
    const auto found = byName_.find(name);
    if (found == byName_.end())
      table.fail(row,
                 fmt::format("no label begins with \"{}\"; write a label's first synonym, or #n, ImageNet's "
                             "number from 0",
                             io::printable(name)));
    if (found->second.size() > 1)
      table.fail(row, fmt::format("{} labels are called \"{}\"; write the number of one, #n",
                                  found->second.size(), io::printable(name)));
    return found->second;
  }

 private:
  std::vector<std::size_t> range(std::string_view item, const CsvTable& table, const io::CsvRow& row) const {
    const std::string shown = io::printable(std::string(item));
    if (labels_ != imageNetClasses && labels_ != imageNetClasses + 1)
      table.fail(row, fmt::format("{} counts ImageNet's {} classes, but the model has {} labels; write names",
                                  shown, imageNetClasses, labels_));
    const std::size_t dash = item.find('-');
    const auto first = number(item.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : number(item.substr(dash + 1));
    if (!first || !last || *first > *last)
      table.fail(row, fmt::format("{} is no range; write #n, or #a-#b with a ≤ b, up to #{}", shown,
                                  imageNetClasses - 1));
    std::vector<std::size_t> labels;
    for (std::size_t n = *first; n <= *last; ++n) labels.push_back(n + labels_ - imageNetClasses);
    return labels;
  }

  /// "#17" → 17; nothing unless it is a class.
  static std::optional<std::size_t> number(std::string_view text) {
    if (!text.starts_with('#')) return std::nullopt;
    text.remove_prefix(1);
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && value < imageNetClasses
               ? std::optional(value)
               : std::nullopt;
  }

  std::size_t labels_;
  std::map<std::string, std::vector<std::size_t>> byName_;
};

std::vector<std::size_t> answersIn(const CsvTable& table, const io::CsvRow& row, const NamedLabels& named) {
  const std::string_view list = table.get(row, "labels");
  std::vector<std::size_t> answers;
  for (std::size_t from = 0; from <= list.size();) {
    const std::size_t end = std::min(list.find('|', from), list.size());
    const std::string_view item = list.substr(from, end - from);
    if (item.empty()) table.fail(row, "a label is empty; write one between two |");
    for (const std::size_t label : named.of(item, table, row)) {
      if (std::ranges::count(answers, label) > 0)
        table.fail(row,
                   fmt::format("{} names a label twice; leave it out", io::printable(std::string(item))));
      answers.push_back(label);
    }
    from = end + 1;
  }
  std::ranges::sort(answers);
  return answers;
}

}  // namespace

std::vector<WordQuery> readWordQueries(const std::filesystem::path& file, const Vocabulary& vocabulary) {
  const CsvTable table(file);
  const NamedLabels named(vocabulary);
  std::vector<WordQuery> queries;
  std::map<std::string, std::size_t> lines;
  for (const io::CsvRow& row : table.rows()) {
    const std::string& text = table.get(row, "query");
    const auto [known, isNew] = lines.emplace(text, row.line);
    if (!isNew)
      table.fail(row, fmt::format("\"{}\" is asked in line {} already", io::printable(text), known->second));
    queries.push_back({table.get(row, "kind"), text, answersIn(table, row, named)});
  }
  if (queries.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: no queries; write lines `kind,query,labels`", table.name()));
  return queries;
}

}  // namespace estancia::experiments
