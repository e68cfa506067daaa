// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/recorded_labeler.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "estancia/core/config.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"
#include "estancia/labelers/black_box.hpp"
#include "estancia/labelers/model_files.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t several = static_cast<std::size_t>(-1);

void note(std::unordered_map<std::string, std::size_t>& records, const std::string& key, std::size_t i) {
  const auto [entry, isNew] = records.emplace(key, i);
  if (!isNew) entry->second = several;
}

}  // namespace

RecordedLabeler::RecordedLabeler(DescriptorSequence recording) : recording_(std::move(recording)) {
  for (std::size_t i = 0; i < recording_.frames.size(); ++i) {
    const fs::path name = recording_.frames[i].name;
    note(byName_, name.string(), i);
    note(byLastPart_, name.filename().string(), i);
    note(byStem_, name.stem().string(), i);
  }
}

std::size_t RecordedLabeler::find(const std::string& frame) const {
  const fs::path name = frame;
  const std::pair<const std::unordered_map<std::string, std::size_t>*, std::string> ways[] = {
      {&byName_, frame}, {&byLastPart_, name.filename().string()}, {&byStem_, name.stem().string()}};
  for (const auto& [records, key] : ways) {
    const auto found = records->find(key);
    if (found == records->end()) continue;
    if (found->second == several)
      throw FrameError(fmt::format("{}: several records could be meant by \"{}\"; record whole names",
                                   recording_.model, frame));
    return found->second;
  }
  throw FrameError(fmt::format("{}: no record of \"{}\" among its {} (first: \"{}\")", recording_.model,
                               frame, recording_.frames.size(), recording_.frames.front().name));
}

Prepared RecordedLabeler::prepare(const cv::Mat&, const std::string& frame) const {
  find(frame);  // fails at once if there is none
  return {{}, frame, {}};
}

LexicalDescriptor RecordedLabeler::infer(const Prepared& prepared) {
  const DescriptorView row = recording_.descriptors.row(find(prepared.frame));
  if (std::ranges::none_of(row, [](float p) { return p > 0; }))
    throw FrameError(fmt::format("{}: \"{}\" has no label", recording_.model, prepared.frame));
  return {row.begin(), row.end()};
}

std::unique_ptr<Labeler> openRecorded(const ModelSpec& spec) {
  ConfigFile config(spec.folder / "model.toml");
  fs::path file, frames;
  DescriptorFileOptions options;
  readBlackBox(config, {{"file", true, "the recording", [&](auto& n) { file = config.inside(n); }},
                        {"frames", false, "the names of an NPY file's rows",
                         [&](auto& n) { frames = config.inside(n); }}});
  if (!spec.labels.empty()) options.labels = modelFile(spec, spec.labels);
  if (!frames.empty()) options.frames = modelFile(spec, frames);
  DescriptorSequence recording = readDescriptors(modelFile(spec, file), options);
  recording.model = blackBoxIdentity(spec, config, {file, frames});
  return std::make_unique<RecordedLabeler>(std::move(recording));
}

}  // namespace estancia
