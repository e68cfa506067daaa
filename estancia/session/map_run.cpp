// SPDX-License-Identifier: Apache-2.0
#include "estancia/session/map_run.hpp"

#include <fmt/format.h>

#include <system_error>

#include "estancia/core/error.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {
namespace {

/// "mapper.tau-revisit is 0.015 in the map, and 0.0015 is given", each; an empty text is an automatic value.
std::string differencesOf(MapperOptions kept, MapperOptions wanted) {
  const auto before = declare(kept).texts(), now = declare(wanted).texts();
  const auto told = [](const std::string& text) { return text.empty() ? "automatic" : printable(text); };
  std::string differences;
  for (const auto& [path, text] : before)
    if (now.at(path) != text)
      differences += fmt::format("{}mapper.{} is {} in the map, and {} is given",
                                 differences.empty() ? "" : ", ", path, told(text), told(now.at(path)));
  return differences;
}

}  // namespace

MapRun::MapRun(std::filesystem::path path, Existing existing) : path_(std::move(path)), existing_(existing) {
  if (existing != Existing::resume) outputTarget(path_);  // reports an invalid output
  std::error_code none;                                   // open() reports an invalid map
  const bool exists = std::filesystem::exists(path_, none);
  if (exists && existing == Existing::refuse)
    throw Error(
        ErrorCode::fileExists,
        fmt::format("{} exists; continue it with --continue, replace it with --overwrite", path_.string()));
  if (!exists) existing_ = Existing::refuse;
}

std::optional<Vocabulary> MapRun::vocabulary() const {
  if (existing_ != Existing::resume) return std::nullopt;
  return MapStore::open(path_, MapStore::Access::read).identity().vocabulary;
}

std::size_t MapRun::begin(const Sequence& sequence, const Vocabulary& vocabulary, const std::string& model,
                          const std::function<void(MapperOptions&)>& change, bool posesAreInMap) {
  if (existing_ != Existing::resume) {
    MapperOptions options;
    change(options);
    const auto existing = existing_ == Existing::replace ? ExistingMap::replace : ExistingMap::refuse;
    start_ = driveStartOf(sequence);
    beginsDrive_ = true;
    create_ = [path = path_, vocabulary, model, options, existing] {
      return MappingSession::create(path, vocabulary, model, options, existing);
    };
    return 0;
  }
  session_ = MappingSession::resume(path_, vocabulary, model);
  framesBefore_ = session_->frames();
  session_->changeBudget(changeBudget_);
  const MapperOptions& kept = session_->mapper().options();
  MapperOptions wanted = kept;
  change(wanted);
  if (wanted != kept)
    fail(ErrorCode::mismatch,
         "{} was made with other parameters of the mapper: {}; leave these, or the preset that gives them, "
         "out to go on with the map's own, or map anew",
         path_.string(), differencesOf(kept, wanted));
  if (const auto next = firstUnmapped(readMap(path_), sequence)) return *next;
  start_ = driveStartOf(sequence);
  start_.posesAreInMap = posesAreInMap || !hasPoses(sequence);
  beginsDrive_ = true;
  return 0;
}

MappingSession& MapRun::start() {
  if (!session_) {
    session_ = create_();
    session_->changeBudget(changeBudget_);
  }
  return *session_;
}

/// With the first frame, so that a sequence of which none can be read is no drive.
bool MapRun::beginDrive() {
  if (!std::exchange(beginsDrive_, false)) return false;
  start().beginDrive(start_);
  return true;
}

void MapRun::add(const Frame& frame, DescriptorView descriptor, const MappingSession::Image& image) {
  beginDrive();
  start().add(frame, descriptor, image);
}

}  // namespace estancia
