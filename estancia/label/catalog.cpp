// SPDX-License-Identifier: Apache-2.0
#include "estancia/label/catalog.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string_view>
#include <system_error>

#include "estancia/core/ascii.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/labelers/model_files.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t maxFileBytes = std::int64_t{1} << 40;

/// Reads one catalog file.
class CatalogReader {
 public:
  CatalogReader(const fs::path& name, const std::string& text) : file_(name, text) {}

  void read(std::map<std::string, CatalogEntry>& models, std::map<std::string, LabelSet>& sets) {
    file_.read({
        {"labels", false, "label sets",
         [&](auto& n) {
           for (const auto& [key, node] : file_.subtable(n)) {
             const std::string name = nameOf(node, key.str());
             sets[name] = labelSet(node);
           }
         }},
        {"models", false, "the models",
         [&](auto& n) {
           for (const auto& [key, node] : file_.subtable(n)) {
             const std::string name = nameOf(node, key.str());
             models[name] = entry(node, name);
           }
         }},
    });
    for (const auto& [name, set] : sets)
      if (!set.words.empty() && (!sets.contains(set.words) || !sets.at(set.words).words.empty()))
        missingSet(name, set.words);
    for (const auto& [name, model] : models)
      if (!model.labels.empty() && !sets.contains(model.labels)) missingSet(name, model.labels);
  }

 private:
  [[noreturn]] void missingSet(const std::string& user, const std::string& set) const {
    fail(ErrorCode::malformedFile,
         "{}: {} names the label set {}, which is missing or takes its words from another; add [labels.{}]",
         file_.path().string(), user, set, set);
  }

  /// A name that is safe as that of a file and of a folder.
  std::string nameOf(const toml::node& node, std::string_view name) const {
    if (!isSafeName(name))
      file_.fail(node, fmt::format("\"{}\" is no name; it must be made of letters, digits, `_`, `-` and `.`, "
                                   "and not start with `.`",
                                   io::printable(name)));
    return std::string(name);
  }

  std::string digest(const toml::node& node) const {
    const std::string hex = hexDigits(file_.text(node), 64);
    if (hex.empty()) file_.fail(node, "`sha256` must be 64 hex digits");
    return hex;
  }

  std::vector<std::string> urls(const toml::node& node) const {
    std::vector<std::string> all;
    for (const auto& one : file_.list(node)) {
      const std::string url = file_.text(one);
      const auto scheme = url.find("://");
      const bool web = url.starts_with("https://") || url.starts_with("http://");
      const bool plain = std::ranges::all_of(url, [](unsigned char c) { return c > ' ' && c < 0x7F; });
      if (!web || !plain || url.size() <= scheme + 3 || url[scheme + 3] == '/')
        file_.fail(one, "`urls` must be addresses that begin with https:// or http://");
      all.push_back(url);
    }
    return all;
  }

  /// The keys that describe where a file comes from.
  std::vector<ConfigFile::Key> fileKeys(CatalogFile& file) {
    return {
        {"urls", false, "where it is", [&](auto& n) { file.remote.urls = urls(n); }},
        {"sha256", false, "its digest", [&](auto& n) { file.remote.sha256 = digest(n); }},
        {"size", false, "its bytes",
         [&](auto& n) { file.remote.size = static_cast<std::uint64_t>(file_.integer(n, 1, maxFileBytes)); }},
        {"member", false, "the file in an archive", [&](auto& n) { file.member = file_.text(n); }},
    };
  }

  LabelSet labelSet(const toml::node& node) {
    LabelSet set;
    auto keys = fileKeys(set.file);
    keys.push_back({"count", true, "how many labels there are",
                    [&](auto& n) { set.count = static_cast<std::size_t>(file_.integer(n, 1, 1'000'000)); }});
    keys.push_back({"numbered", false, "whether lines end with their number",
                    [&](auto& n) { set.numbered = file_.flag(n); }});
    keys.push_back({"words", false, "the set that knows the words of WordNet numbers",
                    [&](auto& n) { set.words = file_.text(n); }});
    file_.read(file_.subtable(node), keys);
    if (set.file.remote.urls.empty()) file_.fail(node, "a label set needs `urls`");
    return set;
  }

  CatalogFile fileOf(const toml::node& node) {
    CatalogFile file;
    auto keys = fileKeys(file);
    keys.push_back({"name", true, "its name in the model's folder",
                    [&](auto& n) { file.name = nameOf(n, file_.text(n)); }});
    keys.push_back({"by_hand", false, "how to make it", [&](auto& n) { file.byHand = file_.text(n); }});
    file_.read(file_.subtable(node), keys);
    if (file.remote.urls.empty() == file.byHand.empty())
      file_.fail(node, fmt::format("{} needs `urls`, or `by_hand` that says how to make it", file.name));
    if (file.name == "model.toml" || file.name.ends_with(".part"))
      file_.fail(node, fmt::format("{} cannot be the name of a model's file", file.name));
    return file;
  }

  CatalogEntry entry(const toml::node& node, const std::string& name) {
    CatalogEntry model;
    model.name = name;
    toml::table settings;
    file_.read(file_.subtable(node),
               {
                   {"about", true, "what it is", [&](auto& n) { model.about = file_.text(n); }},
                   {"license", true, "the model's license", [&](auto& n) { model.license = file_.text(n); }},
                   {"source", true, "where it is described", [&](auto& n) { model.source = file_.text(n); }},
                   {"group", false, "its group", [&](auto& n) { model.group = nameOf(n, file_.text(n)); }},
                   {"labels", false, "its label set", [&](auto& n) { model.labels = file_.text(n); }},
                   {"megabytes", false, "the size of the download",
                    [&](auto& n) { model.megabytes = file_.number(n, 0, 1e6); }},
                   {"files", true, "its files",
                    [&](auto& n) {
                      for (const auto& one : file_.list(n)) model.files.push_back(fileOf(one));
                    }},
                   {"model", true, "its model.toml", [&](auto& n) { settings = file_.subtable(n); }},
               });
    for (const char* key : {"file", "config", "embeddings"})
      if (const auto file = settings[key].value<std::string>()) requireFile(node, model, *file);
    if (model.labels.empty()) requireFile(node, model, "labels.txt");
    settings.insert_or_assign("name", name);
    settings.insert_or_assign("labels", "labels.txt");
    settings.insert_or_assign("license", model.license);
    settings.insert_or_assign("source", model.source);
    std::ostringstream text;
    text << "# " << io::printable(model.about) << "\n" << settings << "\n";
    model.modelToml = text.str();
    return model;
  }

  void requireFile(const toml::node& node, const CatalogEntry& model, const std::string& name) const {
    if (std::none_of(model.files.begin(), model.files.end(), [&](auto& f) { return f.name == name; }))
      file_.fail(node, fmt::format("{} has no file \"{}\" among its `files`{}", model.name, name,
                                   name == "labels.txt" ? ", and no label set as `labels`" : ""));
  }

  ConfigFile file_;
};

bool isWordNetNumber(std::string_view word) {
  return word.size() == 9 && word[0] == 'n' &&
         std::all_of(word.begin() + 1, word.end(), [](unsigned char c) { return std::isdigit(c); });
}

/// A line without its number, which must be `number`.
std::string_view unnumbered(std::string_view line, std::size_t number, const std::string& set) {
  const auto blank = line.rfind(' ');
  if (blank == std::string_view::npos || line.substr(blank + 1) != std::to_string(number))
    fail(ErrorCode::malformedFile,
         "{}:{}: \"{}\" does not end with the number {}; the list is not what it was", set, number + 1,
         io::printable(line), number);
  return line.substr(0, blank);
}

std::map<std::string, std::string, std::less<>> wordNetWords(const std::vector<std::string>& lines) {
  std::map<std::string, std::string, std::less<>> words;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string_view line = unnumbered(lines[i], i, "the list of words");
    if (line.size() > 10 && isWordNetNumber(line.substr(0, 9)) && line[9] == ' ')
      words.emplace(line.substr(0, 9), line.substr(10));
  }
  return words;
}

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
    notes_.push_back(
        fmt::format("{}: no checksum is published; what came has SHA-256 {}", file.name, actual));
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

Catalog Catalog::load() {
  Catalog catalog;
  catalog.add("models/catalog.toml", builtinCatalog);
  const fs::path own = modelHome().parent_path() / "catalog.toml";
  if (fs::exists(own)) catalog.add(own, io::readBytes(own, std::size_t{1} << 24U));
  return catalog;
}

void Catalog::add(const fs::path& name, const std::string& text) {
  CatalogReader(name, text).read(models_, labelSets_);
}

const CatalogEntry& Catalog::get(const std::string& name) const {
  if (const auto found = models_.find(name); found != models_.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [other, model] : models_) known.push_back(other);
  fail(ErrorCode::unknownName, "no model \"{}\" in the catalog; known are {}", io::printable(name),
       fmt::join(known, ", "));
}

std::vector<std::string> Catalog::namesOf(const std::string& name) const {
  std::vector<std::string> names;
  for (const auto& [member, model] : models_)
    if (model.group == name && !models_.contains(name)) names.push_back(member);
  return names.empty() ? std::vector{name} : names;
}

std::string Catalog::checksums(const CatalogEntry& model) const {
  std::vector<RemoteFile> files;
  for (const CatalogFile& file : model.files)
    if (file.byHand.empty()) files.push_back(file.remote);
  for (std::string set = model.labels; !set.empty(); set = labelSets_.at(set).words)
    files.push_back(labelSets_.at(set).file.remote);
  const auto known = [](const RemoteFile& file) { return !file.sha256.empty(); };
  if (std::ranges::all_of(files, known)) return "sha256";
  return std::ranges::any_of(files, known) ? "partly" : "none";
}

bool CatalogEntry::needsHands() const {
  return std::any_of(files.begin(), files.end(), [](const CatalogFile& f) { return !f.byHand.empty(); });
}

std::vector<std::string> labelsOf(const LabelSet& set, const std::vector<std::string>& lines,
                                  const std::vector<std::string>& words) {
  const std::string& list = set.file.name;
  if (lines.size() != set.count)
    fail(ErrorCode::malformedFile,
         "{} has {} lines where {} labels are expected; the list is not what it was", list, lines.size(),
         set.count);
  const auto known = wordNetWords(words);
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::string_view label = set.numbered ? unnumbered(lines[i], i, list) : std::string_view(lines[i]);
    if (set.numbered && label.size() > 3 && label[0] == '/' && label[2] == '/') label.remove_prefix(3);
    if (set.numbered && isWordNetNumber(label)) {
      const auto found = known.find(label);
      if (found == known.end())
        fail(ErrorCode::malformedFile, "{}:{}: no words for {} in the list {}", list, i + 1, label,
             set.words);
      label = found->second;
    } else if (set.numbered && label.size() > 10 && label[9] == ' ' && isWordNetNumber(label.substr(0, 9))) {
      label.remove_prefix(10);
    }
    labels.emplace_back(label);
  }
  return labels;
}

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
