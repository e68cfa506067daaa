#include "estancia/objects/new_samples.hpp"

#include <fmt/format.h>

#include <set>
#include <system_error>

#include "estancia/core/error.hpp"
#include "estancia/io/files.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using io::printable;

/// The folders in a folder of samples.
std::set<fs::path> partsOf(const fs::path& folder) {
  return {imageOf(folder, "x").parent_path(), maskOf(folder, "x").parent_path(),
          cloudOf(folder, "x").parent_path()};
}

/// The files of the samples that the list names.
std::set<fs::path> filesOf(const fs::path& folder) {
  std::set<fs::path> files{folder / "samples.csv", labelFileOf(folder)};
  for (const ObjectSample& sample : readObjectSamples(folder)) {
    files.insert(imageOf(folder, sample.view.name));
    files.insert(maskOf(folder, sample.view.name));
    files.insert(cloudOf(folder, sample.view.name));
  }
  return files;
}

void requireOnlySamples(const fs::path& folder) {
  if (!isObjectSamples(folder))
    throw Error(ErrorCode::fileExists,
                fmt::format("{} is not a folder of samples and is not replaced; give another name",
                            printable(folder.string())));
  const std::set<fs::path> files = filesOf(folder), parts = partsOf(folder);
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (!files.contains(entry.path()) && !(entry.is_directory() && parts.contains(entry.path())))
      throw Error(ErrorCode::fileExists,
                  fmt::format("{} is not one of the samples, so that nothing is replaced; move it away first",
                              printable(entry.path().string())));
}

void requirePlace(const fs::path& folder, bool replace) {
  if (!fs::exists(folder) || (fs::is_directory(folder) && fs::is_empty(folder))) return;
  if (!fs::is_directory(folder) || !replace)
    throw Error(ErrorCode::fileExists,
                fmt::format("{} exists; give another name, or replace its samples by --overwrite",
                            printable(folder.string())));
  requireOnlySamples(folder);
}

/// Runs `work` and turns errors of the file system into an Error about `folder`.
template <class Work>
void onDisk(const fs::path& folder, const char* what, const Work& work) {
  try {
    work();
  } catch (const fs::filesystem_error& e) {
    throw Error(ErrorCode::fileUnwritable,
                fmt::format("{}: the folder cannot be {} ({}); check its parent folder",
                            printable(folder.string()), what, e.code().message()));
  }
}

}  // namespace

// Built upon another constructor, so that what was made is removed when the rest fails.
NewSamples::NewSamples(const fs::path& folder, bool replace) : NewSamples() {
  if (folder.empty()) throw Error(ErrorCode::invalidOption, "the folder of samples has no name; give one");
  onDisk(folder, "made", [&] {
    folder_ = fs::weakly_canonical(fs::absolute(folder / "x"))
                  .parent_path();  // without dots and slashes at its end
    requirePlace(folder_, replace);
    const fs::path part = folder_.string() + ".part";
    if (fs::exists(part)) {
      if (!isObjectSamples(part))
        throw Error(ErrorCode::fileExists,
                    fmt::format("{} exists, where samples are collected first; move it away",
                                printable(part.string())));
      fs::remove_all(part);  // of a run that was killed
    }
    part_ = part;
    for (const fs::path& inside : partsOf(part_)) fs::create_directories(inside);
  });
  writeObjectSamples({}, part_);
}

NewSamples::~NewSamples() {
  std::error_code ignored;
  if (!part_.empty()) fs::remove_all(part_, ignored);
}

void NewSamples::finish(const std::vector<ObjectSample>& samples) {
  writeObjectSamples(samples, part_);
  onDisk(folder_, "replaced", [&] {
    if (fs::exists(folder_) && !fs::is_empty(folder_)) {
      requireOnlySamples(folder_);  // again: others may have written there
      fs::remove_all(folder_);
    }
    fs::rename(part_, folder_);
  });
  part_.clear();
}

}  // namespace estancia
