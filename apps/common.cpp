#include "common.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cstdio>

#include "estancia/core/error.hpp"
#include "estancia/core/progress.hpp"

namespace estancia::apps {

void SequenceArguments::addTo(CLI::App& command, bool required) {
  command.add_option("SEQ", path, "Image folder, video file, data set or folder of panoramas")
      ->required(required);
  std::string types = "How to read SEQ: auto (finds out by itself)";
  for (const auto& [name, explanation] : sequenceTypes())
    types += fmt::format("; {} ({})", name, explanation);
  const auto sequence = "Sequence";
  command.add_option("--type", options.type, types)->group(sequence);
  command
      .add_option("--poses", options.poses,
                  "TUM or KITTI trajectory of the frames; default: poses.txt in SEQ")
      ->group(sequence);
  command.add_option("--rooms", options.rooms, "CSV image,room for evaluation; default: rooms.csv in SEQ")
      ->group(sequence);
  command.add_option("--pose-gap", options.maxPoseGap, "Most seconds between an image and its pose")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e9))
      ->group(sequence);
  command.add_flag("--strict", strict, "Stop at an unreadable image instead of skipping it")->group(sequence);
  const auto tour = "Panorama tour";
  command.add_option("--views", options.views, "Views of each place")->capture_default_str()->group(tour);
  command.add_option("--fov", options.fieldOfView, "Horizontal field of view in degrees")
      ->capture_default_str()
      ->group(tour);
  command.add_option("--turn", options.turn, "Degrees added to every heading")
      ->capture_default_str()
      ->group(tour);
  command.add_option("--ev", options.exposure, "Change of exposure in EV: another light")
      ->capture_default_str()
      ->group(tour);
  command.add_option("--rounds", options.rounds, "How often the tour visits all places")
      ->capture_default_str()
      ->group(tour);
}

std::unique_ptr<Sequence> SequenceArguments::open() const {
  auto sequence = openSequence(path, options);
  for (const std::string& warning : sequence->warnings()) spdlog::warn("{}", warning);
  return sequence;
}

CLI::Validator positive() {
  return CLI::Validator(
      [](const std::string& text) {
        double value = 0;
        const bool above = CLI::detail::lexical_cast(text, value) && value > 0;
        return above ? std::string() : text + " is not a number above 0";
      },
      "POSITIVE");
}

void addJsonOption(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "Print JSON for machines on stdout");
}

void print(const nlohmann::ordered_json& json) {
  // Labels and file names may hold bytes that are no UTF-8: show them as such instead of failing.
  std::puts(json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
}

void addExamples(CLI::App& command, const std::string& examples) {
  command.footer("Examples:\n" + examples);
}

std::size_t forEachLabelled(const Sequence& sequence, Labeler& labeler, std::size_t first, bool strict,
                            const std::string& what, const std::function<void(const LabelledFrame&)>& use) {
  const auto progress = makeStderrProgress();
  LabelStream stream(sequence, labeler, {first, strict});
  std::size_t used = 0, skipped = 0;
  progress->begin(what, sequence.size(), first);
  while (const auto frame = stream.next()) {
    if (frame->labelled()) {
      use(*frame);
      ++used;
    } else {
      ++skipped;
      spdlog::warn("skipped: {}", frame->problem);
    }
    progress->advance();
    if (interrupted())
      throw Interrupted(fmt::format("stopped after {} of {} frames", frame->index + 1, sequence.size()));
  }
  progress->end();
  if (used == 0 && first < sequence.size())
    throw Error(
        fmt::format("{}: none of the {} frames can be read", sequence.name(), sequence.size() - first));
  if (skipped > 0) spdlog::warn("{} unreadable frames were skipped", skipped);
  return skipped;
}

}  // namespace estancia::apps
