// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/vocabulary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/printable_labels.hpp"

namespace estancia {

std::size_t DescriptorLayout::labels() const {
  std::size_t sum = 0;
  for (const LabelPart& part : parts) sum += part.size;
  return sum;
}

Vocabulary::Vocabulary(std::vector<std::string> labels, std::vector<LabelPart> parts)
    : labels_(std::move(labels)), layout_(labels_.size()) {
  if (!parts.empty()) layout_ = std::move(parts);
  if (labels_.empty()) throw Error(ErrorCode::invalidInput, "a vocabulary needs at least one label");
  std::string all;
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    if (labels_[i].empty())
      fail(ErrorCode::invalidInput, "label {} of the vocabulary is empty; name it", i + 1);
    all += labels_[i];
    all += '\n';
  }
  const auto isValid = [](const LabelPart& part) {
    return part.size > 0 && part.weight > 0 && std::isfinite(part.weight);
  };
  if (layout_.labels() != labels_.size() || !std::all_of(layout_.parts.begin(), layout_.parts.end(), isValid))
    fail(ErrorCode::invalidInput,
         "the parts do not make up {} labels; each needs labels and a weight above 0", labels_.size());
  if (layout_.parts.size() > 1)
    for (const LabelPart& part : layout_.parts) all += fmt::format("\n{} {}", part.size, part.weight);
  digest_ = sha256(all);
}

Vocabulary readVocabulary(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) fail(ErrorCode::fileUnreadable, "cannot read the label file {}; check the path", path.string());
  std::vector<std::string> labels;
  std::string line;
  while (std::getline(file, line)) {
    if (labels.empty() && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);  // a byte order mark
    const auto end = line.find_last_not_of(" \t\r");
    labels.push_back(end == std::string::npos ? "" : printableLabel(line.substr(0, end + 1)));
  }
  while (!labels.empty() && labels.back().empty()) labels.pop_back();
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i].empty())
      fail(ErrorCode::malformedFile, "{}:{}: empty label; give every output of the model a name",
           path.string(), i + 1);
  if (labels.empty())
    fail(ErrorCode::malformedFile,
         "{} has no labels; write one label a line, in the order of the model's outputs", path.string());
  return Vocabulary(std::move(labels));
}

void requireSameVocabulary(const Vocabulary& expected, const Vocabulary& actual, const std::string& context) {
  if (expected == actual) return;
  if (expected.labels() == actual.labels())
    fail(ErrorCode::mismatch,
         "{}: the labels are equal, but their models or weights differ; use the model that the "
         "map was made with",
         context);
  std::size_t i = 0;
  while (i < expected.size() && i < actual.size() && expected[i] == actual[i]) ++i;
  const auto labelAt = [i](const Vocabulary& v) { return i < v.size() ? v[i] : std::string("(none)"); };
  fail(ErrorCode::mismatch,
       "{}: the vocabularies differ ({} labels against {}; label {} is \"{}\" against \"{}\"); "
       "use the model that the map was made with",
       context, expected.size(), actual.size(), i + 1, labelAt(expected), labelAt(actual));
}

}  // namespace estancia
