// SPDX-License-Identifier: Apache-2.0
#include "scenes/scenes_data.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/plus_names.hpp"
#include "estancia/describe/table_features.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/feature_table.hpp"
#include "places/room_table.hpp"
#include "scenes/descriptor_figures.hpp"
#include "zones/room_classes.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

/// What a part is called in the features of images. Throws Error listing the known ones.
std::string imagePart(const std::string& part) {
  std::vector<std::string> types;
  for (const auto& [name, explanation] : descriptorTypes()) types.push_back(name);
  if (std::find(types.begin(), types.end(), part) != types.end()) return part;
  try {
    return readModelSpec(getModelFolder(part)).name;
  } catch (const Error& problem) {
    throw Error(problem.code(), fmt::format("the descriptor {} is none of {}, and no model: {}", part,
                                            fmt::join(types, ", "), problem.what()));
  }
}

/// What is compared, and by which names it is asked for.
struct Wanted {
  std::vector<SceneDescriptor> descriptors;
  // sources of all parts, each once: names of types, models or their folders
  std::vector<std::string> sources;
};

/// Names of types and models; any names where there are no images to describe.
Wanted findDescriptors(const ScenesOptions& options, const ExperimentRun& run,
                       std::vector<std::string>& notes) {
  const bool images =
      std::any_of(options.data.begin(), options.data.end(),
                  [](const ScenesOptions::Data& data) { return !isDescriptorFile(data.images.path); });
  Wanted wanted;
  std::set<std::string> names;
  const auto add = [&](const std::string& descriptor) {
    SceneDescriptor found;
    const auto sources = splitAtPlus(descriptor);
    for (const std::string& source : sources) found.parts.push_back(images ? imagePart(source) : source);
    found.name = fmt::format("{}", fmt::join(found.parts, "+"));
    if (!names.insert(found.name).second)
      throw Error(ErrorCode::invalidInput, fmt::format("two descriptors are called {}", found.name));
    for (const std::string& source : sources)
      if (std::find(wanted.sources.begin(), wanted.sources.end(), source) == wanted.sources.end())
        wanted.sources.push_back(source);
    wanted.descriptors.push_back(std::move(found));
  };
  for (const std::string& descriptor : run.models.empty() ? options.descriptors : run.models) add(descriptor);
  if (run.models.empty()) addWhatIsThere(options.optionalDescriptors, add, notes);
  return wanted;
}

/// Where some images come from, opened.
struct Source {
  std::string name;
  const ScenesOptions::Data* data;
  SequenceSource from;
  std::string split;                   // value of the data's split column; "": all
  std::unique_ptr<Sequence> sequence;  // either this …
  std::optional<Features> table;       // … or this
};

/// Labels or other numbers that are in a file already; nothing when there are images.
std::optional<Features> readTable(const ScenesOptions::Data& data, const SequenceSource& from) {
  const fs::path& file = from.path;
  if (!fs::is_regular_file(file) || !isDescriptorFile(file)) return std::nullopt;
  if (!from.options.split.empty())
    throw Error(ErrorCode::invalidOption,
                fmt::format("{}: `split` parts sequences of images; name the other half by [data.test], or a "
                            "`split_column` of a `table`",
                            file.string()));
  if (file.extension() == ".csv") {
    std::vector<std::string> header;
    io::forEachCsvRow(file, [&](const io::CsvRow& row) {
      if (header.empty()) header = row.cells;
    });
    for (const char* column : {"room", "class"})
      if (std::find(header.begin(), header.end(), column) != header.end())
        return featuresOf(readFeatureTable(file, {data.ignored}));
  }
  return featuresOf(readDescriptors(file));
}

Source open(const std::string& name, const ScenesOptions::Data& data, SequenceSource from,
            const std::string& split) {
  // The reader knows the rooms unless a table does, and complains of unknown ones.
  if (data.table.empty()) from.options.only = data.only;
  Source source{name, &data, std::move(from), split, nullptr, std::nullopt};
  source.table = readTable(data, source.from);
  if (!source.table) source.sequence = openSequence(source.from.path, source.from.options);
  return source;
}

/// Keeps the images whose room is known and wanted.
SceneImages withRooms(const Source& source, const Features& all) {
  const ScenesOptions::Data& data = *source.data;
  std::vector<std::string> rooms, splits(all.frames.size());
  if (data.table.empty()) {
    for (const Frame& frame : all.frames) rooms.push_back(frame.room);
  } else {
    const RoomTable table(data.table, data.imageColumn, all.frames);
    rooms = table.column(data.roomColumn);
    if (!data.splitColumn.empty()) splits = table.column(data.splitColumn);
  }
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < rooms.size(); ++i)
    if (!rooms[i].empty() && splits[i] == source.split &&
        (data.only.empty() || std::find(data.only.begin(), data.only.end(), rooms[i]) != data.only.end()))
      kept.push_back(i);
  if (kept.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: no image has a known room{}{}; name them by `table`, or in the images' own "
                            "rooms.csv",
                            source.name, data.only.empty() ? "" : " that is wanted by `only`",
                            source.split.empty() ? "" : " and is \"" + source.split + "\""));
  SceneImages images{source.name, withRows(all, kept), {}, {}, {}};
  std::vector<std::string> keptRooms;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    images.features.frames[k].room = rooms[kept[k]];
    keptRooms.push_back(rooms[kept[k]]);
  }
  images.runs = classesOfRuns(images.features.frames, keptRooms, {}, 1);
  return images;
}

void digest(SceneImages& images) {
  std::string told;
  for (std::size_t i = 0; i < images.runs.size(); ++i)
    told +=
        images.features.frames[i].name + '\n' + images.features.frames[i].room + '\n' + images.runs[i] + '\n';
  images.framesDigest = sha256(told);
  for (const DescriptorPart& part : images.features.parts) {
    const Features one = withParts(images.features, {part.name});
    const auto& values = one.values.values();
    images.partDigests[part.name] = sha256(
        sha256({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)}) +
        part.identity + fmt::format("\n{}\n{}", static_cast<int>(part.kind), fmt::join(part.columns, "\n")));
  }
}

/// Throws Error unless a classifier can learn from these.
void requireLearnable(const SceneImages& images) {
  std::map<std::string, std::size_t> counts;
  for (const Frame& frame : images.features.frames) ++counts[frame.room];
  if (counts.size() < 2)
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: all images show one room, {}; there must be two to tell apart", images.name,
                            counts.begin()->first));
  for (const auto& [room, count] : counts)
    if (count < 2)
      throw Error(ErrorCode::insufficientData,
                  fmt::format("{}: one image of {} is too few to learn from; name the other rooms by `only`",
                              images.name, room));
}

/// None where the first image cannot be read: its labels may be known without it.
std::optional<Images> figuresOf(const Sequence& sequence, const Features& features) {
  for (std::size_t i = 0; i < sequence.size(); ++i) try {
      if (sequence.frame(i).name == features.frames[0].name)
        return descriptorFigures(sequence.image(i), features);
    } catch (const Error&) {
      return std::nullopt;
    }
  return std::nullopt;
}

/// Opens all that is there, and reports what is learned from what.
std::vector<Source> openAll(const ScenesOptions& options, std::vector<std::string>& notes,
                            std::vector<ScenesData::Pair>& pairs) {
  std::vector<Source> sources;
  std::vector<std::size_t> sequences;  // sequences that make pairs with each other
  for (const ScenesOptions::Data& data : options.data) {
    if (data.optional && !fs::exists(data.images.path)) {
      notes.push_back(fmt::format("{} is not there and was left out", data.images.path.string()));
      continue;
    }
    const std::size_t first = sources.size();
    if (data.asked || !data.splitColumn.empty()) {
      const std::string split = data.splitColumn.empty() ? "" : data.train;
      sources.push_back(open(data.name + " train", data, data.images, split));
      sources.push_back(open(data.name + " test", data, data.asked ? *data.asked : data.images,
                             data.splitColumn.empty() ? "" : data.test));
      pairs.push_back({first, first + 1});
    } else {
      sources.push_back(open(data.name, data, data.images, ""));
      sequences.push_back(first);
    }
  }
  for (const std::size_t train : sequences)
    for (const std::size_t test : sequences)
      if (train != test || options.sameSequence) pairs.push_back({train, test});
  if (sources.empty())
    throw Error(ErrorCode::insufficientData, "none of the data is there; name yours by [[data]]");
  if (pairs.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: one sequence alone makes no pair; add another, part it by `split_column` or "
                            "[data.test], or let `same_sequence` be true",
                            sources[0].name));
  return sources;
}

}  // namespace

std::string SceneImages::digest(const std::vector<std::string>& parts) const {
  std::string all = framesDigest;
  for (const std::string& part : parts) all += partDigests.at(part);
  return sha256(all);
}

ScenesData describeScenes(const ScenesOptions& options, const ExperimentRun& run, Progress& progress,
                          std::vector<std::string>& notes) {
  ScenesData data;
  const Wanted wanted = findDescriptors(options, run, notes);
  data.descriptors = wanted.descriptors;
  const std::vector<Source> sources = openAll(options, notes, data.pairs);
  for (const Source& source : sources)
    for (const SceneDescriptor& descriptor : wanted.descriptors) try {
        if (source.table) withParts(withRows(*source.table, {}), descriptor.parts);
      } catch (const Error& problem) {
        throw Error(problem.code(), fmt::format("{}: {}", source.from.path.string(), problem.what()));
      }

  std::optional<Features> features;  // features of the last sequence: halves by a column are described once
  for (std::size_t s = 0; s < sources.size(); ++s) {
    const Source& source = sources[s];
    if (!source.split.empty() && s > 0 && sources[s - 1].data == source.data) {
      data.images.push_back(withRooms(source, source.table ? *source.table : *features));
      digest(data.images.back());
      continue;
    }
    for (const std::string& warning :
         source.sequence ? source.sequence->warnings() : std::vector<std::string>{})
      notes.push_back(fmt::format("{}: {}", source.name, warning));
    if (source.table) {
      data.images.push_back(withRooms(source, *source.table));
    } else {
      std::vector<std::string> problems;
      features = describeSequence(*source.sequence, fmt::format("{}", fmt::join(wanted.sources, "+")),
                                  {run.labeler, run.cache}, progress, &problems);
      if (!problems.empty())
        notes.push_back(fmt::format("{}: {} images were left out, for all descriptors alike; the first: {}",
                                    source.name, problems.size(), problems[0]));
      data.images.push_back(withRooms(source, *features));
      if (s == 0) data.figures = figuresOf(*source.sequence, data.images[0].features);
    }
    digest(data.images.back());
  }
  for (const auto& pair : data.pairs) requireLearnable(data.images[pair.train]);
  for (const DescriptorPart& part : data.images[0].features.parts) data.identities.push_back(part.identity);
  return data;
}

}  // namespace estancia::experiments
