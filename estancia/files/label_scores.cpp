// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/label_scores.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"

namespace estancia::io {
namespace {

using Json = nlohmann::json;

constexpr std::size_t maxLabelBytes = 1000;
constexpr std::size_t maxLabels = 100'000;
constexpr int maxNesting = 64;

std::string excerpt(std::string_view text) {
  constexpr std::size_t maxShown = 80;
  return printable(text.substr(0, maxShown)) + (text.size() > maxShown ? "…" : "");
}

std::string excerptOf(const Json& json) {
  return excerpt(json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

Json parse(std::string_view text, const std::string& source) {
  const auto shallow = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > maxNesting)
      fail(ErrorCode::malformedFile, "{}: JSON with more than {} levels", source, maxNesting);
    return true;
  };
  try {
    return Json::parse(text, shallow);
  } catch (const Json::exception&) {
    const bool notANumber =
        text.find("NaN") != std::string_view::npos || text.find("Infinity") != std::string_view::npos;
    fail(ErrorCode::malformedFile, "{}: not JSON{}: \"{}\"", source,
         notANumber ? " (JSON has neither NaN nor Infinity)" : "", excerpt(text));
  }
}

const Json* find(const Json& answer, const std::string& pointer) {
  try {
    return &answer.at(Json::json_pointer(pointer));
  } catch (const Json::exception&) {
    return nullptr;
  }
}

const Json& wordsIn(const Json& answer, const WordFormat& format, const std::string& source) {
  const Json* words = find(answer, format.at.empty() ? "/labels" : format.at);
  if (words == nullptr && format.at.empty() && answer.is_array()) words = &answer;
  if (words == nullptr)
    fail(ErrorCode::malformedFile, "{}: no labels at {} in {}", source,
         format.at.empty() ? "/labels" : format.at, excerptOf(answer));
  return *words;
}

float confidenceOf(const Json& value, const std::string& label, const WordFormat& format,
                   const std::string& source) {
  if (!value.is_number())
    fail(ErrorCode::malformedFile, "{}: the confidence of \"{}\" is not a number", source, excerpt(label));
  return toProbability(value.get<double>() * format.scale, label, source);
}

LabelProbability wordOf(const Json& element, const WordFormat& format, const std::string& source) {
  const auto member = [&](const std::string& key) -> const Json& {
    const auto found = element.is_object() ? element.find(key) : element.end();
    if (!element.is_object() || found == element.end())
      fail(ErrorCode::malformedFile, "{}: an element of the list of labels has no \"{}\": {}", source, key,
           excerptOf(element));
    return *found;
  };
  const Json& label = member(format.label);
  if (!label.is_string()) fail(ErrorCode::malformedFile, "{}: \"{}\" must be a text", source, format.label);
  std::string name = toLabel(label.get_ref<const std::string&>(), source);
  const float confidence = confidenceOf(member(format.confidence), name, format, source);
  return {std::move(name), confidence};
}

}  // namespace

float toProbability(double value, const std::string& label, const std::string& source) {
  constexpr double slack = 1e-4;                 // tolerance of requireProbabilities()
  if (!(value >= -slack && value <= 1 + slack))  // NaN, too
    fail(ErrorCode::malformedFile,
         "{}: {} for \"{}\" is not a probability; give 0 to 1 (percentages: divide by 100)", source, value,
         excerpt(label));
  return static_cast<float>(std::clamp(value, 0.0, 1.0));
}

std::string toLabel(std::string_view text, const std::string& source) {
  text = trimmed(text, " \t\r\n");
  if (text.empty()) fail(ErrorCode::malformedFile, "{}: empty label", source);
  if (text.size() > maxLabelBytes)
    fail(ErrorCode::malformedFile, "{}: label of {} bytes, at most {}: \"{}\"", source, text.size(),
         maxLabelBytes, excerpt(text));
  return printable(text);
}

void requireJsonPointer(const std::string& at, const std::string& source) {
  try {
    Json::json_pointer{at};
  } catch (const Json::exception&) {
    fail(ErrorCode::invalidOption, "{}: \"{}\" is not a JSON pointer, such as \"/outputs/0/labels\"", source,
         excerpt(at));
  }
}

Answer readAnswer(std::string_view text, const WordFormat& format, const std::string& source) {
  const Json json = parse(text, source);
  Answer answer;
  if (json.is_object()) {
    if (const auto image = json.find("image"); image != json.end() && image->is_string())
      answer.image = image->get<std::string>();
    if (const auto error = json.find("error"); error != json.end() && !error->is_null()) {
      const std::string reason = error->is_string() ? error->get<std::string>() : error->dump();
      answer.error = reason.empty() ? "an error without a reason" : excerpt(reason);
      return answer;
    }
  }
  const Json& words = wordsIn(json, format, source);
  if (words.is_object()) {
    for (const auto& [label, confidence] : words.items()) {
      std::string name = toLabel(label, source);
      const float probability = confidenceOf(confidence, name, format, source);
      answer.words.push_back({std::move(name), probability});
    }
  } else if (words.is_array()) {
    for (const Json& element : words) answer.words.push_back(wordOf(element, format, source));
  } else {
    fail(ErrorCode::malformedFile, "{}: the labels must be {{LABEL: confidence, …}} or a list", source);
  }
  return answer;
}

WordBook::WordBook(Vocabulary vocabulary) : given_(true), vocabulary_(std::move(vocabulary)) {
  for (std::size_t i = 0; i < vocabulary_->size(); ++i)
    places_[(*vocabulary_)[i]].push_back(static_cast<std::uint32_t>(i));
}

const Vocabulary& WordBook::vocabulary() const {
  if (!vocabulary_ || vocabulary_->size() != size()) {
    if (labels_.empty())
      throw Error(ErrorCode::invalidState, "no labels are known yet; label some images first");
    vocabulary_.emplace(labels_);
  }
  return *vocabulary_;
}

WordBook::Places WordBook::place(std::vector<LabelProbability> words, std::size_t best,
                                 const std::string& source) {
  const auto surer = [](const LabelProbability& a, const LabelProbability& b) {
    return a.probability != b.probability ? a.probability > b.probability : a.label < b.label;
  };
  if (discovers()) {  // the order of new labels does not depend on how the answer was written
    std::erase_if(words, [](const LabelProbability& word) { return word.probability == 0; });
    std::ranges::sort(words, surer);
    std::map<std::string_view, bool> seen;
    std::vector<LabelProbability> once;
    for (const LabelProbability& word : words)
      if ((best == 0 || once.size() < best) && seen.emplace(word.label, true).second) once.push_back(word);
    words = std::move(once);
    for (const LabelProbability& word : words) {
      if (places_.contains(word.label)) continue;
      if (labels_.size() == maxLabels)
        fail(ErrorCode::tooLarge, "{}: more than {} different labels; give a label file", source, maxLabels);
      places_[word.label].push_back(static_cast<std::uint32_t>(labels_.size()));
      labels_.push_back(word.label);
    }
  }
  std::map<std::string_view, std::size_t> times;
  std::map<std::uint32_t, float> placed;
  for (const LabelProbability& word : words) {
    const auto found = places_.find(word.label);
    if (found == places_.end()) continue;
    const std::size_t nth = std::min(times[word.label]++, found->second.size() - 1);
    float& value = placed[found->second[nth]];
    value = std::max(value, word.probability);
  }
  Places places(placed.begin(), placed.end());
  if (best > 0 && places.size() > best) {
    std::ranges::stable_sort(places, std::ranges::greater{}, &Places::value_type::second);
    places.resize(best);
    std::ranges::sort(places);
  }
  return places;
}

LexicalDescriptor WordBook::toDescriptor(const Places& places) const {
  LexicalDescriptor descriptor(size(), 0.0F);
  for (const auto& [place, probability] : places) descriptor[place] = probability;
  return descriptor;
}

}  // namespace estancia::io
