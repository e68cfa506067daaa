// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/edits.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/world_file/edit_rules.hpp"

namespace estancia {
namespace {

/// The fields of an edit; each must be asked for.
class EditFields {
 public:
  explicit EditFields(const nlohmann::json& json) : json_(json) {}

  int number(const char* key) {
    const nlohmann::json& value = get(key);
    if (!value.is_number_integer() || value < 0 || value > std::numeric_limits<int>::max())
      fail(ErrorCode::invalidInput, "\"{}\" must be a whole number from 0", key);
    return value.get<int>();
  }
  std::string name(const char* what) {
    const nlohmann::json& value = get("name");
    if (!value.is_string()) fail(ErrorCode::invalidInput, "\"name\" must be text");
    auto text = value.get<std::string>();
    requireGivenName(text, what);
    return text;
  }
  cv::Point2d point(const char* key) {
    const nlohmann::json& value = get(key);
    if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number())
      fail(ErrorCode::invalidInput, "\"{}\" must be a point of the floor, [x, y] in meters", key);
    return {value[0].get<double>(), value[1].get<double>()};
  }
  /// Throws if there are unexpected fields.
  void end() const {
    for (const auto& field : json_.items())
      if (field.key() != "type" && std::ranges::find(asked_, field.key()) == asked_.end())
        fail(ErrorCode::invalidInput, "the edit has a field \"{}\", which is unknown here; it wants {}",
             printable(field.key()), fmt::join(asked_, ", "));
  }

 private:
  const nlohmann::json& get(const char* key) {
    const auto found = json_.find(key);
    if (found == json_.end()) fail(ErrorCode::invalidInput, "the edit lacks \"{}\"", key);
    asked_.emplace_back(key);
    return *found;
  }

  const nlohmann::json& json_;
  std::vector<std::string> asked_;
};

MapEdit editOf(const std::string& type, EditFields& fields) {
  // The values in braces are evaluated from left to right.
  if (type == "name_area") return NameArea{fields.number("area"), fields.name("an area")};
  if (type == "merge_areas") return MergeAreas{fields.number("area"), fields.number("other")};
  if (type == "split_area") return SplitArea{fields.point("from"), fields.point("to")};
  if (type == "name_object") return NameObject{fields.number("object"), fields.name("an object")};
  if (type == "delete_object") return DeleteObject{fields.number("object")};
  fail(ErrorCode::invalidInput,
       "there is no edit \"{}\"; there are name_area, merge_areas, split_area, name_object and delete_object",
       printable(type));
}

}  // namespace

MapEdit parseEdit(const std::string& json) {
  const nlohmann::json parsed = nlohmann::json::parse(json, nullptr, false);
  if (!parsed.is_object() || !parsed.contains("type") || !parsed["type"].is_string())
    fail(ErrorCode::invalidInput, "an edit is a JSON object with a \"type\", {{\"type\": \"name_area\", …}}");
  EditFields fields(parsed);
  MapEdit edit = editOf(parsed["type"].get<std::string>(), fields);
  fields.end();
  return edit;
}

void requireRevision(const std::optional<std::uint64_t>& mapRevision, std::uint64_t now) {
  if (mapRevision && *mapRevision != now)
    fail(ErrorCode::mismatch,
         "the map has changed since revision {}, and its numbers may have; read it again (now {})",
         *mapRevision, now);
}

void editMapFile(const std::filesystem::path& path, const MapEdit& edit) {
  std::visit(
      [&](const auto& what) {
        using What = std::decay_t<decltype(what)>;
        if constexpr (std::is_same_v<What, NameArea>)
          nameArea(path, std::to_string(what.area), what.name);
        else if constexpr (std::is_same_v<What, MergeAreas>)
          mergeAreas(path, std::to_string(what.area), std::to_string(what.other));
        else if constexpr (std::is_same_v<What, SplitArea>)
          splitArea(path, what.from, what.to);
        else if constexpr (std::is_same_v<What, NameObject>)
          nameObject(path, std::to_string(what.object), what.name);
        else
          deleteObject(path, std::to_string(what.object));
      },
      edit);
}

}  // namespace estancia
