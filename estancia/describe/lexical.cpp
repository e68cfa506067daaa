// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/lexical.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <set>
#include <utility>

#include "estancia/core/plus_names.hpp"
#include "estancia/labelers/ensemble.hpp"

namespace estancia {
namespace {

/// NAME of "NAME DIGEST", the identity of a labeler.
std::string nameIn(const std::string& identity) {
  return identity.substr(0, identity.rfind(' '));
}

/// Names of the models behind `count` parts: "A+B" has two. Parts of other ensembles are numbered.
std::vector<std::string> namesOfParts(const std::string& name, std::size_t count) {
  if (count == 1) return {name};
  std::vector<std::string> names = splitAtPlus(name);
  for (std::string& each : names) each = std::filesystem::path(each).filename().string();
  if (names.size() == count && std::set(names.begin(), names.end()).size() == count) return names;
  names.clear();
  for (std::size_t i = 1; i <= count; ++i) names.push_back(fmt::format("{} {}", name, i));
  return names;
}

}  // namespace

std::vector<DescriptorPart> partsOfLabels(const Vocabulary& vocabulary, const std::string& identity) {
  const std::vector<LabelPart>& layout = vocabulary.layout().parts;
  const std::vector<std::string> names = namesOfParts(nameIn(identity), layout.size());
  std::vector<std::string> own = identitiesOfMembers(identity);
  for (std::size_t i = own.size(); i < layout.size(); ++i)
    own.push_back(layout.size() == 1 ? identity : fmt::format("part {} of {}", i + 1, identity));
  std::vector<DescriptorPart> parts;
  auto label = vocabulary.labels().begin();
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const auto end = label + static_cast<std::ptrdiff_t>(layout[i].size);
    parts.push_back({names[i], PartKind::probabilities, {label, end}, own[i]});
    label = end;
  }
  return parts;
}

LabelerDescriptor::LabelerDescriptor(std::unique_ptr<Labeler> labeler) : labeler_(std::move(labeler)) {}

std::vector<DescriptorPart> LabelerDescriptor::parts() const {
  const std::lock_guard lock(mutex_);
  return partsOfLabels(labeler_->vocabulary(), labeler_->identity());
}

std::vector<float> LabelerDescriptor::describe(const View& view) const {
  const Prepared prepared = labeler_->prepare(view.image, view.frame);
  const std::lock_guard lock(mutex_);
  return labeler_->infer(prepared);
}

}  // namespace estancia
