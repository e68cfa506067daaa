// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/features.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/plus_names.hpp"
#include "estancia/describe/lexical.hpp"

namespace estancia {
namespace {

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
    throw Error(e.code(),
                fmt::format("{}; descriptors without a model are {}", e.what(), namesOf(descriptorTypes())));
  }
  return std::make_unique<LabelerDescriptor>(loadModel(name, options));
}

}  // namespace

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

}  // namespace estancia
