// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/edit_rules.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "estancia/areas/frame_poses.hpp"
#include "estancia/areas/plan_areas.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/similar_names.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/stats/moments.hpp"
#include "estancia/world_file/area_names.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/world_options.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {
namespace {

/// The words above the floor, of all views that the map holds.
WordMap wordsOfViews(MapStore& map, const WorldStore& layers, const AreaPlan& plan, const FramePoses& poses,
                     Progress& progress) {
  WordMap words(plan.floor, map.identity().vocabulary.size());
  progress.begin("looking at what was seen", poses.size());
  std::size_t done = 0;
  layers.forEachObservation([&](std::size_t frame, const Observation& seen) {
    if (interrupted()) throw Interrupted("stopped; the map is as it was");
    progress.advance(frame - done);
    done = frame;
    if (!poses[frame]) return true;
    try {
      words.add(map.descriptor(frame), depthOf(seen), seen.camera, *poses[frame]);
    } catch (const Error& e) {
      if (e.code() != ErrorCode::tooLarge) throw;  // the plan does not have it, either
    }
    return true;
  });
  progress.end();
  return words;
}

/// Keeps the edit, and plans the areas anew with it. Objects are as they were, but for their areas. Returns
/// whether the edit changes anything; else the map is left alone.
bool correctAreas(const std::filesystem::path& path, const AreaEdit& edit, Progress& progress) {
  MapStore store = MapStore::open(path, MapStore::Access::write);
  WorldStore layers(store, MapStore::Access::write);
  WorldMap world{store.load()};
  layers.read(world);
  FramePoses poses;
  for (const MappedFrame& frame : world.places.frames) {
    poses.skipTo(frame.number);
    poses.add(frame.pose && frame.pose->isPlausible() ? frame.pose : std::nullopt);
  }
  const Vocabulary& vocabulary = world.places.vocabulary;
  Moments moments(vocabulary.size(), false);
  store.forEachDescriptor(0, [&](std::size_t, DescriptorView descriptor) {
    moments.add(descriptor);
    return true;
  });
  const std::span<const float> mean = moments.mean();
  const AreaOptions options = MapTerms(store).options().value_or(WorldOptions{}).areas;
  const WordMap words = wordsOfViews(store, layers, *world.plan, poses, progress);
  std::vector<std::size_t> starts;
  for (const Drive& drive : world.places.drives)
    starts.push_back(world.places.frames[drive.firstFrame].number);
  const auto planned = correctPlan(*world.plan, edit, {poses, starts}, words, vocabulary,
                                   {mean.begin(), mean.end()}, options.naming);
  if (!planned) return false;
  std::vector<int> areas;
  for (const WorldObject& object : world.objects) areas.push_back(areaOfObject(planned->plan, object.center));
  layers.addEdit(edit);
  layers.putAreas(*planned);
  layers.putObjectAreas(areas);
  store.commit();
  return true;
}

/// Whether the two lie side by side, or the robot drove from one into the other.
bool areJoined(const WorldMap& world, int one, int other) {
  cv::Mat around;
  cv::dilate(world.plan->areaOf == one, around, cv::Mat::ones(3, 3, CV_8U));
  if (cv::countNonZero(around & (world.plan->areaOf == other)) > 0) return true;
  const std::vector<int>& areas = world.areaOfFrame;
  for (std::size_t i = 1; i < areas.size(); ++i)
    if (!world.places.beginsDrive(i) && std::minmax(areas[i - 1], areas[i]) == std::minmax(one, other))
      return true;
  return false;
}

}  // namespace

void requireGivenName(const std::string& name, const char* what) {
  constexpr std::size_t longest = 120;
  if (name.empty()) return;  // takes the name away
  if (name.size() > longest)
    fail(ErrorCode::invalidInput, "the name has {} bytes, at most {} are kept", name.size(), longest);
  if (printable(name) != name)
    fail(ErrorCode::invalidInput, "the name \"{}\" has control characters or is no UTF-8; leave them out",
         printable(name));
  const auto isIn = [](const char* set) { return [set](char c) { return std::strchr(set, c) != nullptr; }; };
  if (std::ranges::all_of(name, isIn(" \t\r\n")))
    fail(ErrorCode::invalidInput, "a name of blanks is none; give a word, or \"\" to take the name away");
  if (std::ranges::all_of(name, isIn(" \t\r\n+-0123456789")))
    fail(ErrorCode::invalidInput, "\"{}\" would be taken for the number of {}; give a name with a word",
         printable(name), what);
  if (const std::string_view word = trimmed(name); word != name)
    fail(ErrorCode::invalidInput, "\"{}\" begins or ends with blanks, and so is not \"{}\"; give that name",
         printable(name), printable(std::string(word)));
}

int numberIn(std::string_view text) {
  int id = -1;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), id);
  return problem == std::errc{} && end == text.data() + text.size() ? id : -1;
}

const WorldArea* findAreaNumber(const WorldMap& world, std::string_view text) {
  return world.findArea(numberIn(text));
}

const WorldArea& getArea(const WorldMap& world, const std::string& area) {
  if (world.areas.empty())
    fail(ErrorCode::insufficientData,
         "the map has no areas; map a drive with depth (`estancia check` tells what is missing)");
  if (const WorldArea* found = findAreaNumber(world, area)) return *found;
  const std::vector<int> called = areasCalled(world, area);
  if (called.size() == 1) return *world.findArea(called.front());
  std::vector<std::string> known;
  for (const WorldArea& candidate : world.areas)
    if (called.empty() || std::ranges::find(called, candidate.id) != called.end())
      known.push_back(fmt::format("{} ({})", candidate.id, candidate.displayName()));
  if (!called.empty())
    fail(ErrorCode::unknownName, "the map has several areas \"{}\": {}; give the number of one",
         printable(area), fmt::join(known, ", "));
  fail(ErrorCode::unknownName, "the map has no area \"{}\"; it has {}", printable(area),
       fmt::join(known, ", "));
}

AreaEdit namingOf(const WorldMap& world, const std::string& area, const std::string& name) {
  requireGivenName(name, "an area");
  const WorldArea& named = getArea(world, area);
  for (const WorldArea& other : world.areas)
    if (other.id != named.id && isSimilar(other.givenName, name))
      fail(ErrorCode::invalidInput,
           "\"{}\" differs only in case from \"{}\", the name of area {}; give that name for the same room, "
           "or another one",
           printable(name), printable(other.givenName), other.id);
  return {AreaEdit::Kind::name, named.center, {}, name};
}

AreaEdit mergeOf(const WorldMap& world, const std::string& area, const std::string& other) {
  const WorldArea &one = getArea(world, area), &two = getArea(world, other);
  if (one.id == two.id)
    fail(ErrorCode::invalidInput, "\"{}\" and \"{}\" are one area; give two", printable(area),
         printable(other));
  if (!areJoined(world, one.id, two.id))
    fail(ErrorCode::invalidInput,
         "areas {} ({}) and {} ({}) do not touch, and the robot never drove from one into the other; merge "
         "what lies between them first",
         one.id, one.displayName(), two.id, two.displayName());
  return {AreaEdit::Kind::merge, one.center, two.center, ""};
}

AreaEdit splitOf(const WorldMap& world, const cv::Point2d& from, const cv::Point2d& to) {
  if (world.areas.empty()) getArea(world, "");
  const cv::Point2d middle = (from + to) / 2;
  const int area = std::isfinite(middle.x) && std::isfinite(middle.y) && cv::norm(middle) < 1e6
                       ? areaAt(*world.plan, middle, world.plan->cells.cell())
                       : -1;
  if (area < 0)
    fail(ErrorCode::invalidInput,
         "({:.2f}, {:.2f}) m, the middle of the line, is in no area; give two points across one", middle.x,
         middle.y);
  return {AreaEdit::Kind::split, from, to, ""};
}

void failUncut(const AreaEdit& split) {
  fail(
      ErrorCode::invalidInput,
      "the line from ({:.2f}, {:.2f}) to ({:.2f}, {:.2f}) m does not cut its area in two; give two points at "
      "the area's borders",
      split.from.x, split.from.y, split.to.x, split.to.y);
}

void nameArea(const std::filesystem::path& map, const std::string& area, const std::string& name) {
  const AreaEdit edit = namingOf(readWorld(map), area, name);
  MapStore store = MapStore::open(map, MapStore::Access::write);
  WorldStore(store, MapStore::Access::write).addEdit(edit);
  store.commit();
}

void mergeAreas(const std::filesystem::path& map, const std::string& area, const std::string& other,
                Progress& progress) {
  correctAreas(map, mergeOf(readWorld(map), area, other), progress);
}

void splitArea(const std::filesystem::path& map, const cv::Point2d& from, const cv::Point2d& to,
               Progress& progress) {
  const AreaEdit edit = splitOf(readWorld(map), from, to);
  if (!correctAreas(map, edit, progress)) failUncut(edit);
}

}  // namespace estancia
