// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/object_search.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/recognition/pose_candidates.hpp"
#include "estancia/recognition/prepared.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;

Json jsonOf(const std::vector<StageReport>& stages) {
  Json json = Json::array();
  for (const StageReport& s : stages)
    json.push_back({{"stage", s.stage}, {"detail", s.detail}, {"seconds", s.seconds}});
  return json;
}

Json jsonOf(const Detection& detection) {
  Json json{{"model", detection.model},
            {"pose", detection.pose.matrix.val},
            {"inliers", detection.inliers},
            {"confidence", detection.confidence}};
  if (!std::isnan(detection.falseAlarmRate)) json["false_alarm_rate"] = detection.falseAlarmRate;
  return json;
}

}  // namespace

std::vector<ModelFile> modelFilesOf(const std::vector<std::string>& words, const std::string& unit) {
  namespace fs = std::filesystem;
  std::vector<ModelFile> files;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    const bool named = equals != std::string::npos && equals > 0 && !fs::exists(word);
    const fs::path file = named ? word.substr(equals + 1) : word;
    const std::string name = named ? word.substr(0, equals) : file.stem().string();
    if (file.empty() || name.empty())
      fail(ErrorCode::invalidOption, "--object {}: give FILE or NAME=FILE", word);
    if (std::ranges::find(files, name, &ModelFile::name) != files.end())
      fail(ErrorCode::invalidOption, "two objects are called {}; name them NAME=FILE", name);
    files.push_back({name, file, unit});
  }
  return files;
}

const SearchedModel& SearchResult::model(const std::string& name) const {
  const auto found = std::ranges::find(models, name, &SearchedModel::name);
  if (found == models.end()) fail(ErrorCode::unknownName, "no model \"{}\"", name);
  return *found;
}

SearchResult searchScene(const Recognizer& recognizer, const std::string& name, const PointCloud& scene,
                         const std::vector<ModelFile>& models, Progress& progress) {
  SearchResult result;
  result.scene = recognizer.prepareScene(name, scene, progress);
  std::vector<std::shared_ptr<const PreparedModel>> prepared;  // outlive the candidates
  std::vector<PoseCandidates> candidates;
  for (const ModelFile& file : models) {
    try {
      SearchedModel model{file.name, readCloud(file.cloud, {.unit = file.unit}), {}};
      prepared.push_back(recognizer.prepareModel(file.name, model.cloud));
      model.stages = prepared.back()->stages();
      candidates.push_back(recognizer.search(*prepared.back(), *result.scene, &model.stages));
      result.models.push_back(std::move(model));
    } catch (...) {
      const Error failure = frameFailure(file.name);
      if (models.size() == 1) throw failure;
      result.failed.emplace_back(file.name, failure.what());
    }
  }
  if (result.models.empty())
    fail(ErrorCode::invalidInput, "none of the {} objects can be used; the first: {}: {}", models.size(),
         result.failed.front().first, result.failed.front().second);
  result.detections = recognizer.verify(candidates, &result.maybe);
  return result;
}

Json toJson(const SearchResult& result) {
  Json json{{"instances", Json::array()}};
  for (const Detection& detection : result.detections) json["instances"].push_back(jsonOf(detection));
  for (const Detection& detection : result.maybe) json["maybe"].push_back(jsonOf(detection));
  for (const auto& [name, reason] : result.failed)
    json["failed"].push_back({{"model", name}, {"reason", reason}});
  return json;
}

Json stagesJson(const SearchResult& result) {
  Json json{{"scene", jsonOf(result.scene->stages())}};
  for (const SearchedModel& model : result.models) json["models"][model.name] = jsonOf(model.stages);
  return json;
}

}  // namespace estancia
