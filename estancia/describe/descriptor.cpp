// Descriptors by their names: computed ones, labels, and several side by side.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/descriptor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/plus_names.hpp"
#include "estancia/describe/esf.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/describe/gist.hpp"
#include "estancia/describe/lexical.hpp"
#include "estancia/describe/phog.hpp"
#include "estancia/labelers/ensemble.hpp"

namespace estancia {
namespace {

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

/// Several descriptors side by side.
class CombinedDescriptor final : public Descriptor {
 public:
  explicit CombinedDescriptor(std::vector<NamedDescriptor> members) : members_(std::move(members)) {}

  std::vector<DescriptorPart> parts() const override {
    std::vector<DescriptorPart> all;
    for (const NamedDescriptor& member : members_)
      for (DescriptorPart& part : member.descriptor->parts()) all.push_back(std::move(part));
    return all;
  }
  bool needsImage() const override {
    return std::ranges::any_of(members_, [](auto& member) { return member.descriptor->needsImage(); });
  }
  bool needsDepth() const override {
    return std::ranges::any_of(members_, [](auto& member) { return member.descriptor->needsDepth(); });
  }
  std::vector<float> describe(const View& view) const override {
    std::vector<float> all;
    for (const NamedDescriptor& member : members_) {
      const std::vector<float> numbers = member.descriptor->describe(view);
      all.insert(all.end(), numbers.begin(), numbers.end());
    }
    return all;
  }

 private:
  std::vector<NamedDescriptor> members_;
};

std::unique_ptr<Descriptor> loadOne(const std::string& name, const LabelerOptions& options) {
  if (auto found = findDescriptor(name)) return found;
  try {
    getModelFolder(name);
  } catch (const Error& e) {
    fail(e.code(), "{}; descriptors without a model are {}", e.what(), namesOf(descriptorTypes()));
  }
  return std::make_unique<LabelerDescriptor>(loadModel(name, options));
}

}  // namespace

Choices descriptorTypes() {
  return {{"phog", "pyramid histogram of oriented gradients (630): the directions of edges, by position"},
          {"gist", "spatial envelope (512): filter energies by scale, direction and position"},
          {"esf", "ensemble of shape functions (640), needs depth: the 3-D shape of the scene"}};
}

std::unique_ptr<Descriptor> findDescriptor(const std::string& name) {
  if (name == "phog") return std::make_unique<Phog>();
  if (name == "gist") return std::make_unique<Gist>();
  if (name == "esf") return std::make_unique<Esf>();
  return nullptr;
}

std::vector<NamedDescriptor> loadDescriptors(const std::string& names, const LabelerOptions& options) {
  std::vector<NamedDescriptor> loaded;
  std::set<std::string> seen;
  for (const std::string& name : splitAtPlus(names)) {
    if (name.empty())
      fail(ErrorCode::invalidOption, "\"{}\" has an empty name; give a descriptor between the plus signs",
           names);
    if (!seen.insert(name).second)
      fail(ErrorCode::invalidOption, "\"{}\" has {} twice; give it once", names, name);
    loaded.push_back({name, loadOne(name, options)});
  }
  return loaded;
}

std::unique_ptr<Descriptor> loadDescriptor(const std::string& names, const LabelerOptions& options) {
  std::vector<NamedDescriptor> loaded = loadDescriptors(names, options);
  if (loaded.size() == 1) return std::move(loaded.front().descriptor);
  return std::make_unique<CombinedDescriptor>(std::move(loaded));
}

// ---- labels (lexical.hpp)

std::vector<DescriptorPart> partsOfLabels(const Vocabulary& vocabulary, const std::string& identity) {
  const std::vector<LabelPart>& layout = vocabulary.layout().parts;
  const std::string name = identity.substr(0, identity.rfind(' '));  // in "NAME DIGEST"
  const std::vector<std::string> names = namesOfParts(name, layout.size());
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
