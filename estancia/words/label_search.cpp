// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_search.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "estancia/core/label_words.hpp"
#include "estancia/words/label_relevance.hpp"
#include "estancia/words/lexicon.hpp"
#include "estancia/words/purposes.hpp"

namespace estancia {
namespace {

// Longer queries are cut: each term costs a walk, each unknown word a search of the lexicon.
constexpr std::size_t maxTerms = 6, maxUnknown = 6, maxWords = 20, maxQueryBytes = 400;

constexpr double minReason = 0.3, minPurpose = 0.5;

/// The beginning of a query up to the maximum length, cut between words if possible.
std::string_view beginningOf(std::string_view words) {
  if (words.size() <= maxQueryBytes) return words;
  return words.substr(0, std::min(maxQueryBytes, words.find_last_of(' ', maxQueryBytes)));
}

std::string withArticle(const std::string& noun) {
  return (std::string_view("aeio").find(noun.front()) == std::string_view::npos ? "a " : "an ") + noun;
}

bool isWordOfCompound(const std::string& word) {
  return word.size() > 1 && !isFunctionWord(word);
}

/// Two words that are known as one, and not together, become one: "tooth brush" → "toothbrush".
std::string withCompounds(const Lexicon& lexicon, const std::string& text) {
  const std::vector<std::string> words = splitText(text);
  std::string joined;
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::string word = words[i];
    if (i + 1 < words.size() && isWordOfCompound(word) && isWordOfCompound(words[i + 1]) &&
        !lexicon.knows(word + ' ' + words[i + 1]) && lexicon.knows(word + words[i + 1]))
      word += words[++i];
    joined += (joined.empty() ? "" : " ") + word;
  }
  return joined;
}

/// Why a label is an answer that is joined to what is asked for.
std::string reasonOfLink(WordLink link, const std::string& asked) {
  switch (link) {
    case WordLink::kindOf:
      return "a kind of " + asked;
    case WordLink::moreGeneral:
      return asked + " is a kind of it";
    case WordLink::partOf:
      return "part of " + asked;
    case WordLink::hasPart:
      return asked + " is part of it";
    case WordLink::defines:
      return "its description names " + asked;
    case WordLink::definedBy:
      return fmt::format("the description of {} names it", asked);
    case WordLink::named:
      return fmt::format("its name holds {}", asked);
    case WordLink::nameOf:
      return asked + " is named after it";
    case WordLink::related:
      break;
  }
  return "related to " + asked;
}

/// The number of the model that a label is of.
std::size_t partOf(const Vocabulary& vocabulary, std::size_t label) {
  std::size_t part = 0, end = vocabulary.layout().parts.front().size;
  while (label >= end) end += vocabulary.layout().parts[++part].size;
  return part;
}

/// The models that have some of these labels.
std::set<std::size_t> partsOf(const Vocabulary& vocabulary, const LabelMatches& matches) {
  std::set<std::size_t> parts;
  for (const LabelMatch& match : matches.labels) parts.insert(partOf(vocabulary, match.label));
  return parts;
}

/// Whether each model has one of these labels, so that others need not be looked for.
bool isInEachPart(const Vocabulary& vocabulary, const LabelMatches& matches) {
  return partsOf(vocabulary, matches).size() == vocabulary.layout().parts.size();
}

/// Matches of probability 1.
LabelMatches certain(const std::vector<std::size_t>& labels) {
  LabelMatches matches;
  for (const std::size_t label : labels) matches.labels.push_back({label, 1, ""});
  return matches;
}

constexpr float usualShareOfNoun = 0.5F;

/// The meaning that half of the word's uses as a noun have.
std::optional<std::uint32_t> usualNoun(const WordGraph& graph, const std::string& word) {
  float all = 0;
  std::optional<Sense> best;
  for (const Sense& sense : graph.lexicon.senses(word)) {
    if (graph.pos(sense.synset) != PartOfSpeech::noun) continue;
    all += sense.probability;
    if (!best || sense.probability > best->probability) best = sense;
  }
  return best && best->probability >= usualShareOfNoun * all ? std::optional(best->synset) : std::nullopt;
}

}  // namespace

LabelSearch::LabelSearch(const Vocabulary& vocabulary, const WordGraph* graph)
    : vocabulary_(vocabulary), graph_(graph) {
  if (graph == nullptr) return;
  senses_ = findLabelSenses(*graph, vocabulary);
  std::set<std::string> words;
  for (std::size_t label = 0; label < vocabulary.size(); ++label) {
    hypernyms_.push_back(senses_[label].senses.empty()
                             ? std::vector<std::pair<std::uint32_t, int>>()
                             : graph->hypernyms(senses_[label].senses.front().synset));
    for (std::string& word : splitText(vocabulary[label])) words.insert(std::move(word));
  }
  for (const auto& ofLabel : hypernyms_)
    for (const auto& [above, distance] : ofLabel) allHypernyms_.push_back(above);
  std::ranges::sort(allHypernyms_);
  allHypernyms_.erase(std::unique(allHypernyms_.begin(), allHypernyms_.end()), allHypernyms_.end());
  labelWords_.assign(words.begin(), words.end());
}

LabelSearch::Query LabelSearch::parse(std::string_view asked) const {
  const Lexicon& lexicon = graph_->lexicon;
  Query query;
  std::vector<std::string> words = splitText(beginningOf(asked));
  if (words.size() > maxWords) words.resize(maxWords);
  std::string corrected;
  std::size_t unknown = 0;
  bool changed = false;
  for (const std::string& word : words) {
    std::string meant = word;
    if (!isFunctionWord(word) && !lexicon.knows(word)) {
      meant = ++unknown > maxUnknown ? "" : correctSpelling(lexicon, labelWords_, word);
      if (meant.empty()) continue;
      changed = true;
    }
    corrected += (corrected.empty() ? "" : " ") + meant;
  }
  if (std::string compound = withCompounds(lexicon, corrected); compound != corrected)
    corrected = std::move(compound), changed = true;
  // "cell phone" is known together; so may be words of which one alone is not.
  const std::string whole = fmt::format("{}", fmt::join(words, " "));
  if (lexicon.knows(whole)) corrected = whole, changed = false;
  // "In" is an inch and "it" a technology, but queries do not mean these.
  std::vector<std::string> terms = lexicon.knows(corrected) && !isFunctionWord(corrected)
                                       ? std::vector{corrected}
                                       : lexicon.terms(corrected);
  std::vector<std::vector<Sense>> starts;
  for (std::string& term : terms) {
    std::vector<Sense> senses = lexicon.senses(term);
    const bool isKnown = std::any_of(query.terms.begin(), query.terms.end(),
                                     [&](const Term& known) { return known.word == term; });
    if (senses.empty() || isKnown) continue;
    if (query.terms.size() == maxTerms) break;
    starts.push_back(senses);
    query.terms.push_back({std::move(term), std::move(senses), {}});
  }
  query.purposes = purposeShares(*graph_, starts, allHypernyms_);
  std::vector<std::vector<float>> walks = graph_->walkEach(starts);
  for (std::size_t i = 0; i < walks.size(); ++i) query.terms[i].visits = std::move(walks[i]);
  query.room = findCommonRoom(*graph_, withoutFunctionWords(corrected));
  if (query.room != nullptr)
    for (const std::string& furnishing : query.room->furnishings)
      query.furnishings.push_back({furnishing, furnishingSenses(*graph_, furnishing), {}});
  if (changed) query.corrected = corrected;
  return query;
}

double LabelSearch::liftOf(const Term& term, std::size_t label) const {
  double ratio = 0;
  for (const Sense& sense : senses_[label].senses)
    ratio += static_cast<double>(sense.probability) * std::exp(graph_->lift(term.visits, sense.synset));
  return std::log(std::max(ratio, std::exp(WordGraph::minLift)));
}

/// The largest share of the term, and of the room's furnishings.
double LabelSearch::kindOf(const Query& query, std::size_t label) const {
  double share = query.terms.size() == 1 ? kindShare(query.terms.front().senses, hypernyms_[label]) : 0;
  for (const Term& furnishing : query.furnishings)
    share = std::max(share, usualShare * kindShare(furnishing.senses, hypernyms_[label]));
  return share;
}

std::vector<double> LabelSearch::probabilities(const Query& query) const {
  std::vector<double> results(vocabulary_.size(), 0);
  if (query.terms.empty()) return results;
  std::vector<double> lifts(vocabulary_.size(), minUsedLift);
  for (std::size_t label = 0; label < lifts.size(); ++label) {
    if (senses_[label].senses.empty()) continue;
    double sum = 0;
    for (const Term& term : query.terms) sum += liftOf(term, label);
    lifts[label] = usedLift(sum / static_cast<double>(query.terms.size()));
  }
  std::vector<double> best;  // among the labels of the same model: each has words of its own for a thing
  auto from = lifts.begin();
  for (const LabelPart& part : vocabulary_.layout().parts) {
    const auto to = from + static_cast<std::ptrdiff_t>(part.size);
    best.insert(best.end(), part.size, *std::max_element(from, to));
    from = to;
  }
  for (std::size_t label = 0; label < lifts.size(); ++label) {
    if (senses_[label].senses.empty()) continue;
    results[label] = labelRelevance(
        {lifts[label], best[label], kindOf(query, label), inheritedShare(query.purposes, hypernyms_[label])});
  }
  return results;
}

std::vector<double> LabelSearch::probabilities(std::string_view words) const {
  return graph_ == nullptr ? std::vector<double>(vocabulary_.size(), 0) : probabilities(parse(words));
}

std::vector<double> LabelSearch::likely(const Query& query, double minProbability) const {
  std::vector<double> results = probabilities(query);
  if (query.terms.size() > 1) minProbability *= shareOfSeveral;
  const double near = results.empty() ? 0 : nearTheBest * *std::ranges::max_element(results);
  for (std::size_t label = 0; label < results.size(); ++label)
    if (results[label] < minProbability || (results[label] < near && kindOf(query, label) == 0))
      results[label] = 0;
  return results;
}

std::vector<double> LabelSearch::likely(std::string_view words) const {
  return graph_ == nullptr ? std::vector<double>(vocabulary_.size(), 0)
                           : likely(parse(words), defaultMinProbability);
}

/// The word that the label serves best; "" where that is not its purpose.
std::string LabelSearch::servedVerb(const Query& query, std::size_t label,
                                    const TermPurposes& ofTerms) const {
  if (inheritedShare(query.purposes, hypernyms_[label]) < minPurpose) return "";
  std::string verb;
  double best = 0;
  for (std::size_t t = 0; t < query.terms.size(); ++t) {
    const double share = inheritedShare(ofTerms[t], hypernyms_[label]);
    if (share <= best) continue;
    best = share;
    verb = query.terms[t].word;
  }
  return verb;
}

std::string LabelSearch::reasonFor(const Query& query, std::size_t label, const TermPurposes& ofTerms) const {
  if (senses_[label].senses.empty()) return "";
  const auto weight = [&](const Term& one) { return liftOf(one, label); };
  const auto term = std::ranges::max_element(query.terms, {}, weight);
  const auto isAsked = [&](std::uint32_t synset) {
    return std::any_of(term->senses.begin(), term->senses.end(),
                       [&](const Sense& sense) { return sense.synset == synset; });
  };
  // "Vehicles", which is no entry of its own: "a kind of vehicle".
  const bool isEntry = graph_->lexicon.find(term->word).has_value();
  for (const auto& [above, distance] : hypernyms_[label])
    if (isAsked(above))
      return (distance == 0 ? "the same as " : "a kind of ") +
             (isEntry ? term->word : std::string(graph_->name(above)));
  for (const Term& furnishing : query.furnishings)
    if (kindShare(furnishing.senses, hypernyms_[label]) > minReason)
      return "usual in " + withArticle(query.room->name);
  if (const std::string verb = servedVerb(query, label, ofTerms); !verb.empty())
    return "its purpose is " + (verb.ends_with("ing") ? verb : "to " + verb);
  // Back along the edges that brought most of the walkers.
  constexpr int maxHops = 4;
  std::vector<std::uint32_t> way{senses_[label].senses.front().synset};
  std::optional<WordLink> last;
  for (int hop = 0; hop < maxHops && !isAsked(way.back()); ++hop) {
    const std::uint32_t at = way.back();
    double most = 0;
    std::optional<std::uint32_t> best;
    for (std::uint32_t e = graph_->edgeStarts[at]; e < graph_->edgeStarts[at + 1]; ++e) {
      const std::uint32_t from = graph_->edgeTargets[e];
      const double brought =
          static_cast<double>(graph_->edgeWeights[e] * term->visits[from] / graph_->degrees[from]);
      if (brought <= most || std::find(way.begin(), way.end(), from) != way.end()) continue;
      most = brought;
      best = from;
      last = static_cast<WordLink>(graph_->edgeLinks[e]);
    }
    if (!best) break;
    way.push_back(*best);
  }
  if (!isAsked(way.back())) return "related to " + term->word;
  if (way.size() > 2)
    return fmt::format("related to {} by way of {}", term->word, graph_->name(way[way.size() - 2]));
  return reasonOfLink(*last, term->word);
}

LabelMatches LabelSearch::search(std::string_view words, std::size_t count, double minProbability) const {
  words = beginningOf(words);
  LabelMatches matches = certain(labelsNamed(vocabulary_, words));
  if (isInEachPart(vocabulary_, matches)) return matches;
  const std::vector<std::size_t> held = findLabels(vocabulary_, words);
  if (graph_ == nullptr) return matches.labels.empty() ? certain(held) : matches;
  const Query query = parse(words);
  if (!query.corrected.empty()) {
    if (!matches.labels.empty()) return matches;  // a name that WordNet does not know
    matches = certain(labelsNamed(vocabulary_, query.corrected));
    matches.corrected = query.corrected;
    if (isInEachPart(vocabulary_, matches)) return matches;
  }
  std::vector<double> probability = likely(query, minProbability);
  const std::set<std::size_t> named = partsOf(vocabulary_, matches);
  if (named.empty())
    for (const std::size_t label : held) probability[label] = std::max(probability[label], minProbability);
  else  // where a model has the thing itself, others add what is one, not what belongs to it
    for (std::size_t label = 0; label < probability.size(); ++label)
      if (named.contains(partOf(vocabulary_, label)) || kindOf(query, label) == 0) probability[label] = 0;
  std::vector<std::size_t> order(probability.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return probability[a] > probability[b]; });
  TermPurposes ofTerms;
  for (const Term& term : query.terms)
    ofTerms.push_back(purposeShares(*graph_, {&term.senses, 1}, allHypernyms_));
  for (const std::size_t label : order) {
    if (probability[label] == 0 || matches.labels.size() >= count) break;
    matches.labels.push_back(
        {label, probability[label], query.terms.empty() ? "" : reasonFor(query, label, ofTerms)});
  }
  return matches;
}

LabelMatches findLabelMatches(const Vocabulary& vocabulary, std::string_view words, WordGraphSource source) {
  LabelMatches named = certain(labelsNamed(vocabulary, beginningOf(words)));
  if (isInEachPart(vocabulary, named)) return named;
  return LabelSearch(vocabulary, source == nullptr ? nullptr : source()).search(words);
}

std::vector<LabelMatch> findLabelKinds(const Vocabulary& vocabulary, const WordGraph& graph,
                                       std::string_view words) {
  const std::string word = lexicalForm(words);
  const std::optional<std::uint32_t> asked = usualNoun(graph, word);
  if (!asked) return {};
  std::vector<LabelMatch> kinds;
  const std::vector<LabelSense> senses = findLabelSenses(graph, vocabulary);
  for (std::size_t label = 0; label < senses.size(); ++label) {
    if (senses[label].isDoubtful || senses[label].senses.empty()) continue;
    for (const auto& [above, distance] : graph.hypernyms(senses[label].senses.front().synset))
      if (above == *asked) {
        kinds.push_back({label, 1, (distance == 0 ? "the same as " : "a kind of ") + word});
        break;
      }
  }
  return kinds;
}

LabelMatches chooseLabels(const Vocabulary& vocabulary, std::string_view words, WordGraphSource source) {
  LabelMatches chosen = certain(findLabels(vocabulary, words));
  return chosen.labels.empty() ? findLabelMatches(vocabulary, words, source) : chosen;
}

std::vector<std::string> describeMatches(const Vocabulary& vocabulary, std::span<const LabelMatch> matches,
                                         std::size_t shown) {
  std::vector<std::string> texts;
  for (const LabelMatch& match : matches) {
    const std::string label = shortLabel(vocabulary[match.label]);
    if (match.reason.empty())
      texts.push_back(label);
    else if (texts.size() < shown)
      texts.push_back(fmt::format("{} ({})", label, match.reason));
  }
  if (texts.size() < matches.size()) texts.push_back(fmt::format("{} more", matches.size() - texts.size()));
  return texts;
}

}  // namespace estancia
