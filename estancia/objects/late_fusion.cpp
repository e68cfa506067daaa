#include "estancia/objects/late_fusion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "estancia/core/error.hpp"

namespace estancia {
namespace {

/// Mean gray. Of 164 objects of NYU's rooms Inception v3 named 49 % rightly, darkened to a mean of 0.1 (with
/// noise of 1.5 of 255) 43 %, of 0.05 30 %, of 0.025 14 %; but its own confidence fell from 67 to 48 % only.
constexpr double dark = 0.1;

/// With less the labeler means something else: of those objects 31 % were named rightly below, 55 % above; of
/// 270 renderings 58 % and 80 %.
constexpr float leastMass = 0.02F;

/// The largest and smallest share that what was held out can prove: there are some dozens a word.
constexpr double surest = 0.95;

struct Answer {
  std::size_t word;
  double probability;
};

/// Nothing where nothing is said.
std::optional<Answer> answerOf(DescriptorView shares, const TargetClasses& study) {
  if (shares.empty()) return std::nullopt;
  requireProbabilities(shares, study.words.size(), "the evidence of an object");
  const auto best = std::ranges::max_element(shares);
  if (!(*best > 0)) return std::nullopt;
  return Answer{static_cast<std::size_t>(best - shares.begin()), *best};
}

double logOdds(double p) {
  p = std::clamp(p, 1 - surest, surest);
  return std::log(p / (1 - p));
}

std::string percent(double share) {
  return fmt::format("{:.0f} %", 100 * share);
}

/// Why the image cannot be relied on; "" where it can.
std::string doubtOf(const ObjectEvidence& evidence, const std::optional<Answer>& seen) {
  if (evidence.seen.empty()) return "no image was asked about";
  if (!(evidence.brightness >= dark))
    return fmt::format("it is too dark to be seen, {} of white", percent(evidence.brightness));
  if (!seen) return "the labeler says nothing of the study's words";
  if (!(evidence.mass >= leastMass))
    return fmt::format("the labeler means something else, the study's words are {:.1f} % of its answer",
                       100 * evidence.mass);
  return "";
}

FusedAnswer believed(FusedAnswer::Source source, const Answer& answer, std::string why) {
  return {source, static_cast<int>(answer.word), answer.probability, std::move(why)};
}

/// Two different words, of which one is more likely right.
FusedAnswer moreLikely(const ObjectModel& model, const Answer& seen, const Answer& shape) {
  const double agreement = model.agreement()[shape.word];
  // What was never held out neither speaks for the shape nor against it.
  const double forShape = logOdds(shape.probability) + (agreement < 0 ? 0 : logOdds(agreement));
  const bool trustsShape = forShape > logOdds(seen.probability);
  const std::string tried =
      agreement < 0 ? "how often such shapes are right is not known"
                    : fmt::format("such shapes were right in {} of what was held out", percent(agreement));
  const auto& words = model.study().words;
  return believed(trustsShape ? FusedAnswer::Source::shape : FusedAnswer::Source::seen,
                  trustsShape ? shape : seen,
                  fmt::format("the image says {} {}, the shape {} {}: {}, which makes the {} more likely",
                              words[seen.word].name, percent(seen.probability), words[shape.word].name,
                              percent(shape.probability), tried, trustsShape ? "shape" : "image"));
}

}  // namespace

FusedAnswer fuseAnswers(const ObjectModel& model, const ObjectEvidence& evidence) {
  using Source = FusedAnswer::Source;
  const TargetClasses& study = model.study();
  const std::optional<Answer> seen = answerOf(evidence.seen, study), shape = answerOf(evidence.shape, study);
  const auto said = [&](const Answer& answer) {
    return fmt::format("{} {}", study.words[answer.word].name, percent(answer.probability));
  };
  if (evidence.flat)
    return {Source::none, -1, 0,
            seen ? fmt::format("it is flat: an image of something, or a single face; the image says {}",
                               said(*seen))
                 : "it is flat: an image of something, or a single face"};
  const std::string doubt = doubtOf(evidence, seen);
  if (!doubt.empty() && !shape)
    return {Source::none, -1, 0, doubt + ", and its shape could not be described"};
  if (!doubt.empty())
    return believed(Source::shape, *shape, fmt::format("{}; the shape says {}", doubt, said(*shape)));
  if (!shape)
    return believed(Source::seen, *seen,
                    fmt::format("its shape could not be described; the image says {}", said(*seen)));
  if (seen->word == shape->word)
    return believed(Source::both, {seen->word, std::max(seen->probability, shape->probability)},
                    fmt::format("image and shape agree on {}, {} and {}", study.words[seen->word].name,
                                percent(seen->probability), percent(shape->probability)));
  return moreLikely(model, *seen, *shape);
}

}  // namespace estancia
