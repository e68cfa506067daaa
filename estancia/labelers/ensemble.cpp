// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/ensemble.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/plus_names.hpp"

namespace estancia {
namespace {

constexpr std::size_t maxMembers = 100;

std::vector<EnsembleMember> checked(std::vector<EnsembleMember> members, const std::string& name,
                                    Fusion fusion) {
  if (members.empty())
    fail(ErrorCode::invalidInput, "the ensemble {} has no members; name at least one", name);
  const auto isSound = [](float value) { return value > 0 && std::isfinite(value); };
  for (EnsembleMember& member : members) {
    if (!member.labeler->members().empty())
      fail(ErrorCode::invalidInput, "the ensemble {} holds another ensemble; name its models themselves",
           name);
    if (member.labeler->discovers())
      fail(ErrorCode::invalidInput,
           "the ensemble {} holds a model that discovers its words; give that model a label file, or label "
           "with it first and take the file as a recording",
           name);
    if (!member.weight)
      member.weight = fusion == Fusion::probabilities
                          ? 1.0F
                          : std::sqrt(static_cast<float>(member.labeler->vocabulary().size()));
    if (!isSound(*member.weight) || !isSound(member.temperature))
      fail(ErrorCode::invalidOption, "the ensemble {}: weights and temperatures must be numbers above 0",
           name);
  }
  return members;
}

using Places = std::vector<std::vector<std::size_t>>;

/// Where each label of each member stands in the joined list. Merged: its n-th "crane" is the other's n-th.
Places placesOf(const std::vector<EnsembleMember>& members, Fusion fusion) {
  Places places;
  std::map<std::pair<std::string, std::size_t>, std::size_t> known;
  std::size_t next = 0;
  for (const EnsembleMember& member : members) {
    std::map<std::string, std::size_t> seen;
    auto& own = places.emplace_back();
    for (const std::string& label : member.labeler->vocabulary().labels()) {
      if (fusion == Fusion::distances) {
        own.push_back(next++);
        continue;
      }
      const auto [place, isNew] = known.try_emplace({label, seen[label]++}, next);
      if (isNew) ++next;
      own.push_back(place->second);
    }
  }
  return places;
}

Vocabulary joined(const std::vector<EnsembleMember>& members, const Places& places, Fusion fusion) {
  std::vector<std::string> labels;
  std::vector<LabelPart> parts;
  for (std::size_t m = 0; m < members.size(); ++m) {
    const Vocabulary& own = members[m].labeler->vocabulary();
    for (std::size_t i = 0; i < own.size(); ++i) {
      if (places[m][i] >= labels.size()) labels.resize(places[m][i] + 1);
      labels[places[m][i]] = own[i];
    }
    parts.push_back({own.size(), *members[m].weight});
  }
  if (fusion == Fusion::probabilities || members.size() == 1) parts.clear();
  return Vocabulary(std::move(labels), std::move(parts));
}

/// p^(1/T), with the sum that it had: a distribution stays one, and independent labels keep their mass.
LexicalDescriptor tempered(LexicalDescriptor p, float temperature) {
  if (temperature == 1) return p;
  // Relative to the largest, which no temperature makes vanish; rounding may have left values below 0.
  const float largest = p.empty() ? 0.0F : *std::max_element(p.begin(), p.end());
  if (!(largest > 0)) return p;
  double before = 0, after = 0;
  for (float& value : p) {
    value = std::max(value, 0.0F);
    before += value;
    value = std::pow(value / largest, 1 / temperature);
    after += value;
  }
  for (float& value : p) value = static_cast<float>(std::min(1.0, value * before / after));
  return p;
}

}  // namespace

Ensemble::Ensemble(std::string name, std::vector<EnsembleMember> members, Fusion fusion)
    : members_(checked(std::move(members), name, fusion)),
      fusion_(fusion),
      places_(placesOf(members_, fusion)),
      vocabulary_(joined(members_, places_, fusion)) {
  std::string all = fusion == Fusion::distances ? "distances" : "probabilities";
  for (const EnsembleMember& member : members_)
    all += fmt::format("\n{} {} {}", member.labeler->identity(), *member.weight, member.temperature);
  identity_ = fmt::format("{} {}", name, sha256(all));
}

std::vector<std::size_t> Ensemble::regionLabels() const {
  std::vector<std::size_t> all;
  if (fusion_ == Fusion::probabilities) return all;
  for (std::size_t m = 0; m < members_.size(); ++m)
    for (const std::size_t label : members_[m].labeler->regionLabels()) all.push_back(places_[m][label]);
  return all;
}

std::vector<LexicalDescriptor> Ensemble::labelRegions(const cv::Mat& bgr,
                                                      std::span<const cv::Rect2d> regions) {
  if (regionLabels().empty()) return Labeler::labelRegions(bgr, regions);
  std::vector<LexicalDescriptor> all(regions.size());
  for (const EnsembleMember& member : members_) {
    if (member.labeler->regionLabels().empty()) continue;
    const auto found = member.labeler->labelRegions(bgr, regions);
    for (std::size_t r = 0; r < all.size(); ++r)
      all[r].insert(all[r].end(), found[r].begin(), found[r].end());
  }
  return all;
}

bool Ensemble::needsImage() const {
  return std::any_of(members_.begin(), members_.end(),
                     [](const EnsembleMember& member) { return member.labeler->needsImage(); });
}

std::vector<Labeler*> Ensemble::members() {
  std::vector<Labeler*> all;
  for (const EnsembleMember& member : members_) all.push_back(member.labeler.get());
  return all;
}

std::string Ensemble::cacheKey() const {
  std::string key = identity_;
  for (const EnsembleMember& member : members_) key += '\n' + member.labeler->cacheKey();
  return key;
}

LexicalDescriptor Ensemble::combine(std::span<const LexicalDescriptor> answers) const {
  if (answers.size() != members_.size())
    fail(ErrorCode::mismatch, "{} answers for the {} members of an ensemble", answers.size(),
         members_.size());
  float sum = 0;
  for (const EnsembleMember& member : members_) sum += *member.weight;
  LexicalDescriptor all(vocabulary_.size(), 0.0F);
  for (std::size_t m = 0; m < members_.size(); ++m) {
    const float share = fusion_ == Fusion::probabilities ? *members_[m].weight / sum : 1;
    const LexicalDescriptor own = tempered(answers[m], members_[m].temperature);
    for (std::size_t i = 0; i < own.size(); ++i) all[places_[m][i]] += share * own[i];
  }
  return all;
}

Prepared Ensemble::prepare(const cv::Mat& bgr, const std::string& frame) const {
  Prepared prepared{{}, frame, {}};
  for (const EnsembleMember& member : members_)
    prepared.members.push_back(member.labeler->prepare(bgr, frame));
  return prepared;
}

LexicalDescriptor Ensemble::infer(const Prepared& prepared) {
  std::vector<LexicalDescriptor> answers;
  for (std::size_t m = 0; m < members_.size(); ++m)
    answers.push_back(members_[m].labeler->infer(prepared.members.at(m)));
  return combine(answers);
}

std::unique_ptr<Labeler> openEnsemble(const ModelSpec& spec, const LabelerOptions& options) {
  ConfigFile file(spec.folder / "model.toml");
  std::vector<EnsembleMember> members;
  Fusion fusion = Fusion::distances;
  const auto addMember = [&](const toml::node& node) {
    if (members.size() == maxMembers) file.fail(node, fmt::format("more than {} members", maxMembers));
    EnsembleMember member;
    std::string model;
    if (const auto* table = node.as_table())
      file.read(*table, {{"model", true, "the member's name", [&](auto& n) { model = file.text(n); }},
                         {"weight", false, "how much it counts",
                          [&](auto& n) { member.weight = static_cast<float>(file.number(n, 1e-6, 1e6)); }},
                         {"temperature", false, "how sure it is of itself", [&](auto& n) {
                            member.temperature = static_cast<float>(file.number(n, 0.01, 100));
                          }}});
    else
      model = file.text(node);
    const auto beside = spec.folder / model;
    const bool isBeside = std::filesystem::is_regular_file(beside / "model.toml");
    const ModelSpec own = readModelSpec(getModelFolder(isBeside ? beside.string() : model));
    // Before it is opened: it may hold this one.
    if (own.type == "ensemble")
      file.fail(node, fmt::format("the member {} is an ensemble; name its models themselves", model));
    member.labeler = loadModel(own, options);
    members.push_back(std::move(member));
  };
  file.read({{"name", true, "the model's name", [](auto&) {}},
             {"type", true, "ensemble", [](auto&) {}},
             {"license", false, "the model's license", [](auto&) {}},
             {"source", false, "where the model comes from", [](auto&) {}},
             {"members", true, "the models that work together",
              [&](auto& n) {
                for (const auto& member : file.list(n)) addMember(member);
              }},
             {"fusion", false, "how their words are put together", [&](auto& n) {
                fusion = file.choice<Fusion>(
                    n, {{"distances", Fusion::distances}, {"probabilities", Fusion::probabilities}});
              }}});
  return std::make_unique<Ensemble>(spec.name, std::move(members), fusion);
}

std::unique_ptr<Labeler> openEnsemble(const std::string& names, const LabelerOptions& options) {
  std::vector<EnsembleMember> members;
  for (const std::string& name : splitAtPlus(names)) {
    if (name.empty()) fail(ErrorCode::unknownName, "\"{}\": name the models between the plus signs", names);
    members.push_back({loadModel(name, options), std::nullopt, 1});
  }
  return std::make_unique<Ensemble>(names, std::move(members), Fusion::distances);
}

std::vector<std::string> identitiesOfMembers(const std::string& identity) {
  std::vector<std::string> identities;
  const std::string names = identity.substr(0, identity.rfind(' '));
  if (names.find('+') == std::string::npos) return identities;
  LabelerOptions unopened;
  unopened.onDemand = true;
  for (const Precision precision : {Precision::float32, Precision::int8})
    for (const bool reduced : {false, true}) try {
        unopened.precision = precision;
        unopened.reducedImages = reduced;
        const auto ensemble = openEnsemble(names, unopened);
        if (ensemble->identity() != identity) continue;
        for (const Labeler* member : ensemble->members()) identities.push_back(member->identity());
        return identities;
      } catch (const Error&) {  // not at hand
      }
  return identities;
}

}  // namespace estancia
