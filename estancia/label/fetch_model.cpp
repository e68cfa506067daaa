// fetchModel() of catalog.hpp.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "estancia/core/ascii.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/fetch/archive.hpp"
#include "estancia/files/files.hpp"
#include "estancia/label/catalog.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t maxListBytes = 1U << 24U;

/// A file name for the content of `url` that is also meaningful to people.
std::string archiveName(const std::string& url) {
  std::string name = fmt::format("archive-{}-", sha256(url).substr(0, 6));
  for (const char c : url.substr(url.rfind('/') + 1, 60))
    name += isLetterOrDigit(c) || c == '.' || c == '_' ? c : '-';
  return name;
}

/// Fills a model's download folder. Life cycle: constructed for one entry of the catalog, then fetch() once.
/// Invariant: `model.toml` lists checksums only after all files were verified, so an interrupted fetch can be
/// repeated.
class Fetcher {
 public:
  Fetcher(const Catalog& catalog, const CatalogEntry& entry, const FetchOptions& options, Progress& progress)
      : catalog_(catalog),
        entry_(entry),
        progress_(progress),
        options_(options),
        folder_(downloadFolder(entry.name)) {}

  const fs::path& folder() const { return folder_; }

  void fetch() {
    prepare();
    for (const CatalogFile& file : entry_.files)
      if (file.byHand.empty()) {
        get(file, longest(), options_.download.maxBytes);
        digests_ += fmt::format("\"{}\" = \"{}\"\n", file.name, verified(file));
      }
    if (!entry_.labels.empty()) writeLabels();
    writeWhole(folder_ / "model.toml", entry_.modelToml + "\n[sha256]\n" + digests_);
  }

  std::vector<std::string> notes() const { return notes_; }

 private:
  /// A file of unknown size may be twice as long as the model's size: a server that never ends fills no disk.
  std::uint64_t longest() const {
    const auto told = static_cast<std::uint64_t>(entry_.megabytes * 2e6) + 1'000'000;
    return entry_.megabytes > 0 ? std::min(options_.download.maxBytes, told) : options_.download.maxBytes;
  }

  /// Everything that can be known to be wrong before hours of downloading.
  void prepare() {
    std::error_code problem;
    fs::create_directories(folder_, problem);
    if (problem)
      fail(ErrorCode::fileUnwritable,
           "cannot make the folder {} ({}); set ESTANCIA_HOME to a folder of yours", folder_.string(),
           problem.message());
    writeWhole(folder_ / "model.toml", entry_.modelToml);
    readModelSpec(folder_);
    for (const CatalogFile& file : entry_.files)
      if (!file.byHand.empty() && !fs::is_regular_file(folder_ / file.name))
        fail(ErrorCode::fileNotFound, "{} of {} is yours to make: {}; put it at {} and run this again",
             file.name, entry_.name, file.byHand, (folder_ / file.name).string());
    if (options_.refetch)
      for (const auto& item : fs::directory_iterator(folder_))
        if (std::ranges::none_of(entry_.files, [&](const CatalogFile& file) {
              return file.name == item.path().filename() && !file.byHand.empty();
            }))
          fs::remove(item.path(), problem);
  }

  /// `downloaded`, `extracted`: the most bytes of what comes, and of the file that is taken out of it.
  void get(const CatalogFile& file, std::uint64_t downloaded, std::uint64_t extracted) {
    const fs::path target = folder_ / file.name;
    DownloadOptions options = options_.download;
    options.maxBytes = downloaded;
    if (file.member.empty()) return download(file.remote, target, options, progress_);
    if (fs::is_regular_file(target)) return;  // extracted before, or put there by hand
    std::string reasons;
    for (const std::string& url : file.remote.urls) {
      RemoteFile one = file.remote;
      one.urls = {url};
      const fs::path archive = folder_ / archiveName(url);
      try {
        download(one, archive, options, progress_);
        if (extractMember(archive, file.member, target, extracted)) return;
        reasons += fmt::format("{} holds no {}; ", url, file.member);
      } catch (const Interrupted&) {
        throw;
      } catch (const Error& e) {
        std::error_code ignored;
        fs::remove(archive, ignored);  // whatever it is, the next run should not take it for an archive
        reasons += std::string(e.what()) + "; ";
      }
    }
    fail(ErrorCode::network, "{}put {} at {} by hand, then run this again", reasons, file.member,
         target.string());
  }

  /// SHA-256 of a file; notes when none is published to compare it with.
  std::string verified(const CatalogFile& file) {
    std::string actual = sha256OfFile(folder_ / file.name);
    if (!file.remote.sha256.empty()) return actual;
    notes_.push_back(fmt::format(
        "{}: {}; what came has SHA-256 {}", file.name,
        file.remote.sha1.empty() ? "no checksum is published" : "only a SHA-1 is published, which agrees",
        actual));
    return actual;
  }

  std::vector<std::string> linesOf(const std::string& set) {
    CatalogFile file = catalog_.labelSets().at(set).file;
    file.name = set + ".list";
    get(file, file.member.empty() ? maxListBytes : options_.download.maxBytes, maxListBytes);
    verified(file);
    auto lines = io::readLines(folder_ / file.name);
    while (!lines.empty() && lines.back().empty()) lines.pop_back();
    return lines;
  }

  void writeLabels() {
    LabelSet set = catalog_.labelSets().at(entry_.labels);
    set.file.name = entry_.labels;
    const auto words = set.words.empty() ? std::vector<std::string>{} : linesOf(set.words);
    std::string text;
    for (const std::string& label : labelsOf(set, linesOf(entry_.labels), words)) text += label + "\n";
    writeWhole(folder_ / "labels.txt", text);
    digests_ += fmt::format("\"labels.txt\" = \"{}\"\n", sha256(text));
  }

  const Catalog& catalog_;
  const CatalogEntry& entry_;
  Progress& progress_;
  const FetchOptions& options_;
  fs::path folder_;
  std::string digests_;
  std::vector<std::string> notes_;
};

}  // namespace

fs::path downloadFolder(const std::string& model) {
  return modelHome().parent_path() / "downloads" / model;
}

OptionGroup declare(FetchOptions& options) {
  OptionGroup group("fetch", "How a model is fetched.");
  group.add("replace", &options.replace, "Replace an installed model of the same name.");
  group.add("refetch", &options.refetch, "Fetch again what an earlier run has left.");
  return group;
}

FetchedModel fetchModel(const Catalog& catalog, const std::string& name, const FetchOptions& options,
                        Progress& progress) {
  const CatalogEntry& entry = catalog.get(name);
  if (fs::exists(modelHome() / name) && !options.replace)
    fail(ErrorCode::fileExists, "there is a model {} already in {}; use --overwrite to fetch it again", name,
         modelHome().string());
  Fetcher fetcher(catalog, entry, options, progress);
  fetcher.fetch();
  FetchedModel result;
  try {
    result.check = addModel(fetcher.folder(), options.replace);
  } catch (const Error& e) {
    fail(e.code(), "{}; the files are kept in {}: try --restart if a download may be at fault", e.what(),
         fetcher.folder().string());
  }
  result.notes = fetcher.notes();
  std::error_code ignored;
  fs::remove_all(fetcher.folder(), ignored);
  return result;
}

}  // namespace estancia
