// SPDX-License-Identifier: Apache-2.0
#include "common.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>

#include "estancia/classify/room_classifier.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia::apps {

void SequenceArguments::addTo(DeclaredOptions& declared, bool required, bool withRooms) {
  declared.command()
      .add_option("SEQ", path,
                  "Image folder, video file, ROS bag, data set, folder of panoramas, or label file")
      ->required(required);
  declared.add(declare(options), {"type", "poses", "split", "only", "max-pose-gap", "views", "field-of-view",
                                  "turn", "exposure", "rounds"});
  declared.addFlags("sequence", {"image-topic=image"});
  if (declared.command().get_option_no_throw("--odom") == nullptr)
    declared.addFlags("sequence", {"odom-topic=odom"});
  if (withRooms) declared.addFlags("sequence", {"rooms"});
}

void SequenceArguments::addDepthTo(DeclaredOptions& declared) {
  declared.addFlags("sequence", {"depth-scale", "intrinsics", "depth-topic=depth"});
}

std::unique_ptr<Sequence> SequenceArguments::openQuietly() const {
  if (isMapFile(path))
    throw Error(ErrorCode::unsupportedFile, fmt::format("{} is a map; give the images themselves", path));
  return openSequence(path, options);
}

std::unique_ptr<Sequence> SequenceArguments::open() const {
  auto sequence = openQuietly();
  for (const std::string& warning : sequence->warnings()) spdlog::warn("{}", warning);
  return sequence;
}

void requireNoData(const std::filesystem::path& output, const std::vector<std::string>& inputs,
                   std::string_view start) {
  namespace fs = std::filesystem;
  const fs::path target = outputTarget(output);
  std::error_code none;  // a missing input is reported by its reader
  for (const std::string& input : inputs)
    if (fs::equivalent(target, input, none))
      throw Error(
          ErrorCode::fileExists,
          fmt::format("{} is an input of the command; give the output another name", output.string()));
  if (isMapFile(output) || isZoneFile(output) || isRoomClassifier(output))
    throw Error(
        ErrorCode::fileExists,
        fmt::format("{} is a map, a file of zones or a room classifier and is not replaced by another "
                    "kind of file; give another name",
                    output.string()));
  if (start.empty() || !fs::is_regular_file(target) || fs::file_size(target) == 0) return;
  std::string there(start.size(), '\0');
  std::ifstream(target, std::ios::binary).read(there.data(), static_cast<std::streamsize>(there.size()));
  if (there != start)
    throw Error(ErrorCode::fileExists,
                fmt::format("{} exists and is another kind of file, so it is not replaced; give another "
                            "name or remove it first",
                            output.string()));
}

void requireReplaceable(const std::filesystem::path& output, bool overwrite,
                        bool (*isOurs)(const std::filesystem::path&), std::string_view what) {
  namespace fs = std::filesystem;
  const fs::path folder = output.parent_path();
  std::error_code problem;
  if (!folder.empty() && !fs::is_directory(folder, problem))
    throw Error(ErrorCode::fileNotFound,
                fmt::format("{}: there is no such folder; make it first", folder.string()));
  const fs::path target = outputTarget(output);
  if (!fs::exists(target)) return;
  if (!overwrite)
    throw Error(ErrorCode::fileExists,
                fmt::format("{} exists; replace it with --overwrite", output.string()));
  const bool isReplaceable =
      fs::is_regular_file(target) && (isOurs == nullptr || fs::file_size(target) == 0 || isOurs(output));
  if (!isReplaceable)
    throw Error(ErrorCode::fileExists,
                fmt::format("{}: no {}, so it is not replaced; give another name or remove it first",
                            output.string(), what));
}

void requireImage(const std::string& image, bool overwrite, const std::vector<std::string>& inputs) {
  if (image.empty()) return;
  requireNoData(image, inputs, pngStart);
  requireReplaceable(image, overwrite, nullptr, "image");
  if (!image.ends_with(".png"))
    throw Error(ErrorCode::unsupportedFile,
                fmt::format("{}: images are written as PNG only; call it NAME.png", image));
}

CLI::Validator wholeNumber(int least, int most) {
  return CLI::Validator(
      [least, most](const std::string& text) {
        const std::optional<double> value = io::toNumber(text);
        const bool fits = value && *value >= least && *value <= most && *value == std::floor(*value);
        return fits ? "" : fmt::format("\"{}\" is no whole number from {} to {}", text, least, most);
      },
      fmt::format("{}-{}", least, most));
}

CLI::Option* addOutputOption(CLI::App& command, std::string& output, const std::string& help) {
  return command.add_option("-o,--output", output, help)->type_name("FILE");
}

CLI::Option* addOverwriteOption(CLI::App& command, bool& overwrite) {
  return command.add_flag("--overwrite", overwrite, "Replace an existing output");
}

void addPosesInMapOption(CLI::App& command, bool& posesInMap) {
  command.add_flag(
      "--poses-in-map", posesInMap,
      "The poses of this drive are in the frame of the map that it goes on with; else they are brought "
      "there by the places that are recognized");
}

std::string nameBesideResults(const std::string& work) {
  return isatty(STDOUT_FILENO) == 1 ? "" : work;
}

nlohmann::ordered_json toJson(const std::vector<Measure>& measures) {
  nlohmann::ordered_json json;
  for (const Measure& measure : measures) {
    auto& value = json[measure.key];
    if (measure.value && measure.decimals == 0)
      value = static_cast<std::int64_t>(*measure.value);
    else if (measure.value)
      value = *measure.value;
  }
  return json;
}

std::size_t print(const std::vector<Measure>& measures) {
  std::size_t known = 0;
  for (const Measure& measure : measures) {
    if (!measure.value) continue;
    fmt::print("{:<26} {:>8}   {}\n", measure.name, measure.text(), measure.explanation);
    ++known;
  }
  return known;
}

}  // namespace estancia::apps
