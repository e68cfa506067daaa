// Model catalog: models that can be downloaded, with addresses, licenses and settings.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/fetch/download.hpp"
#include "estancia/labelers/model.hpp"

namespace estancia {

/// A file of a model.
struct CatalogFile {
  /// In the model's folder.
  std::string name;
  /// The download; no addresses if `byHand` describes how to make it instead.
  RemoteFile remote;
  /// When that is an archive: the file in it.
  std::string member;
  /// One sentence for people.
  std::string byHand;
};

/// A list of labels that several models share.
struct LabelSet {
  std::size_t count = 0;
  CatalogFile file;
  /// Lines end with their number and may begin with a folder's letter or a WordNet number, as in
  /// "/a/airport_terminal 2" and "n01440764 tench, Tinca tinca 0": only the words between are the label.
  bool numbered = false;
  /// The set that knows the words of lines with a WordNet number and nothing else.
  std::string words;
};

struct CatalogEntry {
  std::string name, about, license, source;
  /// Models of one group are fetched by its name, too: "thesis", the seven of its Table 1.2; "": of none.
  std::string group;
  std::vector<CatalogFile> files;
  /// A label set; "" when the label file is among `files`.
  std::string labels;
  /// Approximate size of the download [MB].
  double megabytes = 0;
  /// Its model.toml, but for the digests.
  std::string modelToml;

  /// Whether some of the files cannot be had but must be made.
  bool needsHands() const;
};

/// models/catalog.toml, compiled in.
extern const std::string builtinCatalog;

class Catalog {
 public:
  /// The entries of this library and of the user's own catalog.toml beside the model home; where a name is
  /// in both, the user's. Throws Error `…/catalog.toml:LINE: …` on a mistake.
  static Catalog load();

  /// Adds the entries of a catalog's text; `name` stands for the file in messages. Throws Error as above.
  void add(const std::filesystem::path& name, const std::string& text);

  /// By name.
  const std::map<std::string, CatalogEntry>& models() const { return models_; }
  const std::map<std::string, LabelSet>& labelSets() const { return labelSets_; }
  /// Throws Error listing the known names.
  const CatalogEntry& get(const std::string& name) const;
  /// The models of a group; of none such, `name` itself.
  std::vector<std::string> namesOf(const std::string& name) const;
  /// Published digests of the files that are fetched: "sha256" of all, "partly", or "none".
  std::string checksums(const CatalogEntry& model) const;

 private:
  std::map<std::string, CatalogEntry> models_;
  std::map<std::string, LabelSet> labelSets_;
};

/// The labels of a set in order, from the lines as they are published; `words` are the lines of the set that
/// set.words names. Throws Error `FILE:LINE: …` on lines that do not have the format of `set`.
std::vector<std::string> labelsOf(const LabelSet& set, const std::vector<std::string>& lines,
                                  const std::vector<std::string>& words);

struct FetchOptions {
  /// An installed model of that name.
  bool replace = false;
  /// Fetch again what an earlier run has left.
  bool refetch = false;
  DownloadOptions download;
};

OptionGroup declare(FetchOptions& options);

struct FetchedModel {
  ModelCheck check;
  /// Text that lists what could not be verified.
  std::vector<std::string> notes;
};

/// Where downloads wait until the model is complete: DOWNLOADS/NAME, beside the model home.
std::filesystem::path downloadFolder(const std::string& model);

/// Downloads a model into downloadFolder(), checks it and installs it as addModel() does. Files that the user
/// has put there are used. Throws Error, and Interrupted; what has arrived is then kept for the next run.
FetchedModel fetchModel(const Catalog& catalog, const std::string& name, const FetchOptions& options = {},
                        Progress& progress = Progress::none());

}  // namespace estancia
