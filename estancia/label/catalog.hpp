// The models that can be had: where from, under which license, and how to use them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/fetch/download.hpp"
#include "estancia/label/model.hpp"

namespace estancia {

/// A file of a model.
struct CatalogFile {
  std::string name;    ///< in the model's folder
  RemoteFile remote;   ///< what is downloaded; no addresses when `byHand` says how to make it instead
  std::string member;  ///< when that is an archive: the file in it
  std::string byHand;  ///< one sentence for people
};

/// A list of labels that several models share.
struct LabelSet {
  std::size_t count = 0;
  CatalogFile file;
  /// Lines end with their number and may begin with a folder's letter or a WordNet number, as in
  /// "/a/airport_terminal 2" and "n01440764 tench, Tinca tinca 0": only the words between are the label.
  bool numbered = false;
  std::string words;  ///< the set that knows the words of lines with a WordNet number and nothing else
};

struct CatalogEntry {
  std::string name, about, license, source;
  std::vector<CatalogFile> files;
  std::string labels;     ///< a label set; "" when the label file is among `files`
  double megabytes = 0;   ///< of the whole download, about
  std::string modelToml;  ///< its model.toml, but for the digests

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

  /// Adds what a catalog's text says; `name` stands for the file in messages. Throws Error as above.
  void add(const std::filesystem::path& name, const std::string& text);

  /// By name.
  const std::map<std::string, CatalogEntry>& models() const { return models_; }
  const std::map<std::string, LabelSet>& labelSets() const { return labelSets_; }
  /// Throws Error listing the known names.
  const CatalogEntry& get(const std::string& name) const;
  /// What is published of the files that are fetched: "sha256" or "sha1" of all, "partly", or "none".
  std::string checksums(const CatalogEntry& model) const;

 private:
  std::map<std::string, CatalogEntry> models_;
  std::map<std::string, LabelSet> labelSets_;
};

/// The labels of a set in order, from the lines as they are published; `words` are the lines of the set that
/// set.words names. Throws Error `FILE:LINE: …` on lines that are not as `set` says.
std::vector<std::string> labelsOf(const LabelSet& set, const std::vector<std::string>& lines,
                                  const std::vector<std::string>& words);

struct FetchOptions {
  bool replace = false;  ///< an installed model of that name
  bool anew = false;     ///< fetch again what an earlier run has left
  DownloadOptions download;
};

struct FetchedModel {
  ModelCheck check;
  std::vector<std::string> notes;  ///< what could not be verified, for people
};

/// Where downloads wait until the model is complete: DOWNLOADS/NAME, beside the model home.
std::filesystem::path downloadFolder(const std::string& model);

/// Downloads a model into downloadFolder(), checks it and installs it as addModel() does. Files that the user
/// has put there are used. Throws Error, and Interrupted; what has arrived is then kept for the next run.
FetchedModel fetchModel(const Catalog& catalog, const std::string& name, Progress& progress,
                        const FetchOptions& options = {});

}  // namespace estancia
