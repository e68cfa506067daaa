// Map names: output of `estancia map` about objects that known clouds and object models have named.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/layers/known_objects.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/world/world_mapper.hpp"

namespace estancia::apps {

/// Sources of object names beside the labeler.
class ObjectNamers {
 public:
  /// `known`: clouds; `model`: file of `objects train`, "" for none. Reads them.
  ObjectNamers(const std::vector<ModelFile>& known, const std::string& model);
  void giveTo(WorldMapper& mapper) const;
  /// How many objects of the finished map have names by them, a line each; "recognized" and "shapes",
  /// {NAME: objects}, are added to the summary.
  std::string addNames(const std::string& map, nlohmann::ordered_json& summary) const;

 private:
  std::shared_ptr<const KnownObjects> known_;
  std::optional<ObjectModel> model_;
  std::string digest_;
};

}  // namespace estancia::apps
