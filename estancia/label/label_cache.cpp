// SPDX-License-Identifier: Apache-2.0
#include "estancia/label/label_stream.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <cerrno>
#include <cstring>
#include <unordered_map>
#include <utility>

#include "estancia/core/bytes.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/home.hpp"
#include "estancia/files/files.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

// A file: the head, the model's name, then records. All numbers are little-endian.
constexpr std::string_view magic = "ESTCACHE";
constexpr std::uint32_t version = 1;
constexpr std::uint32_t maxName = 1 << 16, maxValue = 1 << 26;  // larger ones are taken for damage
constexpr std::size_t keyBytes = 32;                            // SHA-256
constexpr const char* suffix = ".cache";

constexpr std::size_t headBytes = magic.size() + 8;
constexpr std::size_t recordHeadBytes = 8 + keyBytes;

/// The head of a record: length of the value, checksum, key; the value follows.
struct RecordHead {
  std::uint32_t bytes = 0;
  std::uint32_t checksum = 0;
  std::string key;
};

std::string notCached(const fs::path& folder, const std::string& why) {
  return fmt::format(
      "{}: labels are not being cached ({}); make room there, or name another folder in ESTANCIA_CACHE",
      folder.string(), why);
}

std::uint32_t checksumOf(const std::string& key, std::string_view value) {
  ByteWriter checked;
  checked.number(static_cast<std::uint32_t>(value.size()));
  checked.raw(key);
  boost::crc_32_type crc;
  crc.process_bytes(checked.bytes().data(), checked.bytes().size());
  crc.process_bytes(value.data(), value.size());
  return crc.checksum();
}

std::string recordOf(const std::string& key, std::string_view value) {
  ByteWriter record;
  record.number(static_cast<std::uint32_t>(value.size()));
  record.number(checksumOf(key, value));
  record.raw(key);
  record.raw(value);
  return record.bytes();
}

bool readExactly(int file, void* to, std::size_t bytes, std::uint64_t at) {
  auto* next = static_cast<char*>(to);
  while (bytes > 0) {
    const ssize_t got = pread(file, next, bytes, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    next += got;
    at += static_cast<std::uint64_t>(got);
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

std::vector<fs::path> filesIn(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, fs::path>> found;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    std::error_code gone;
    const auto used = entry.last_write_time(gone);
    if (!gone && entry.path().extension() == suffix) found.emplace_back(used, entry.path());
  }
  std::sort(found.rbegin(), found.rend());  // used last comes first
  std::vector<fs::path> files;
  for (auto& [used, path] : found) files.push_back(std::move(path));
  return files;
}

std::uint64_t sizeOf(const fs::path& file) {
  std::error_code gone;
  const auto bytes = fs::file_size(file, gone);
  return gone ? 0 : bytes;
}

}  // namespace

/// One model's log. Opened without a lock: whole records only ever appear at its end.
class LabelCache::File {
 public:
  enum class Use { labels, statistics };
  explicit File(fs::path path, Use use = Use::labels) : path_(std::move(path)), use_(use) { scan(); }
  ~File() { close(); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  const fs::path& path() const { return path_; }
  const std::string& name() const { return name_; }
  std::size_t images() const { return places_.size(); }

  std::optional<std::string> find(const std::string& key) const {
    const auto place = places_.find(key);
    if (place == places_.end()) return std::nullopt;
    const auto head = readRecordHead(place->second);
    if (!head || head->bytes > maxValue || head->key != key) return std::nullopt;
    std::string value(head->bytes, '\0');
    if (!readExactly(descriptor_, value.data(), value.size(), place->second + recordHeadBytes) ||
        head->checksum != checksumOf(key, value))
      return std::nullopt;
    return value;
  }

  /// Throws Error when the record could not be written whole.
  void append(const std::string& model, const std::string& key, std::string_view value) {
    if (value.size() > maxValue) return;
    if (descriptor_ < 0 || !writable_) create(model);
    const std::string record = recordOf(key, value);
    flock(descriptor_, LOCK_EX);
    while (!isInPlace()) {  // another process has cleared or shortened the log: go on in the new one
      scan();
      if (descriptor_ < 0 || !writable_) create(model);
      flock(descriptor_, LOCK_EX);
    }
    const off_t end = lseek(descriptor_, 0, SEEK_END);
    const bool written = end >= 0 && writeAll(record);
    if (!written && end >= 0 && ftruncate(descriptor_, end) != 0) close();
    flock(descriptor_, LOCK_UN);
    if (!written) throw Error(ErrorCode::fileUnwritable, std::strerror(errno));
    places_[key] = static_cast<std::uint64_t>(end);
  }

  /// Keeps the newer records, at most `bytes` of them.
  void keepNewest(std::uint64_t bytes) {
    scan();  // others may have written, too
    if (descriptor_ < 0) return;
    flock(descriptor_, LOCK_EX);
    std::vector<std::uint64_t> places;
    for (const auto& [key, place] : places_) places.push_back(place);
    std::sort(places.begin(), places.end());
    const std::uint64_t size = sizeOf(path_);
    const auto first = std::find_if(places.begin(), places.end(),
                                    [&](std::uint64_t place) { return size - place <= bytes; });
    const std::uint64_t from = first == places.end() ? size : *first;
    const fs::path fresh = path_.string() + fmt::format(".{}", getpid());
    {
      const int source = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
      const int target = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
      std::string block(1 << 20, '\0');
      bool whole = source >= 0 && target >= 0 && copy(source, target, 0, headBytes_, block) &&
                   copy(source, target, from, size, block);
      if (source >= 0) ::close(source);
      if (target >= 0 && ::close(target) != 0) whole = false;
      if (!whole || std::rename(fresh.c_str(), path_.c_str()) != 0) unlink(fresh.c_str());
    }
    scan();
  }

 private:
  static bool copy(int source, int target, std::uint64_t from, std::uint64_t to, std::string& block) {
    for (std::uint64_t at = from; at < to;) {
      const std::size_t part = std::min<std::uint64_t>(block.size(), to - at);
      if (!readExactly(source, block.data(), part, at) ||
          ::write(target, block.data(), part) != static_cast<ssize_t>(part))
        return false;
      at += part;
    }
    return true;
  }

  void close() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
  }

  bool writeAll(const std::string& bytes) const {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t now = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
      if (now < 0 && errno == EINTR) continue;
      if (now <= 0) return false;
      done += static_cast<std::size_t>(now);
    }
    return true;
  }

  /// Whether the open file is still the one that others find under its name.
  bool isInPlace() const {
    struct stat ours {
    }, named{};
    return fstat(descriptor_, &ours) == 0 && ::stat(path_.c_str(), &named) == 0 &&
           ours.st_ino == named.st_ino && ours.st_dev == named.st_dev;
  }

  /// Opens the log and notes where its records are, up to the first that is cut off.
  void scan() {
    close();
    places_.clear();
    name_.clear();
    writable_ = true;
    if (use_ == Use::labels) descriptor_ = ::open(path_.c_str(), O_RDWR | O_APPEND | O_CLOEXEC);
    if (descriptor_ < 0) {
      writable_ = false;
      descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    }
    if (descriptor_ < 0) return;
    if (sizeOf(path_) == 0) return close();  // another process is about to begin it
    if (!readName()) return discard();
    headBytes_ = headBytes + name_.size();
    const std::uint64_t size = sizeOf(path_);
    std::uint64_t at = headBytes_;
    while (at + recordHeadBytes <= size) {
      const auto record = readRecordHead(at);
      if (!record || record->bytes > maxValue) break;
      const std::uint64_t next = at + recordHeadBytes + record->bytes;
      if (next > size) break;
      places_[record->key] = at;
      at = next;
    }
    // A record that is cut off would swallow those appended after it.
    if (at < size && writable_) {
      flock(descriptor_, LOCK_EX);
      if (sizeOf(path_) == size && ftruncate(descriptor_, static_cast<off_t>(at)) != 0) writable_ = false;
      flock(descriptor_, LOCK_UN);
    }
    if (writable_) futimens(descriptor_, nullptr);  // used now
  }

  /// False when the file is not ours, or of another version.
  bool readName() {
    std::string bytes(headBytes, '\0');
    if (!readExactly(descriptor_, bytes.data(), bytes.size(), 0)) return false;
    ByteReader head(bytes, path_.string(), "delete it");
    const bool ours = head.raw(magic.size()) == magic && head.number<std::uint32_t>() == version;
    const auto nameBytes = head.number<std::uint32_t>();
    if (!ours || nameBytes > maxName) return false;
    name_.resize(nameBytes);
    return readExactly(descriptor_, name_.data(), name_.size(), headBytes);
  }

  std::optional<RecordHead> readRecordHead(std::uint64_t at) const {
    std::string bytes(recordHeadBytes, '\0');
    if (!readExactly(descriptor_, bytes.data(), bytes.size(), at)) return std::nullopt;
    ByteReader reader(bytes, path_.string(), "delete it");
    RecordHead head;
    head.bytes = reader.number<std::uint32_t>();
    head.checksum = reader.number<std::uint32_t>();
    head.key = reader.raw(keyBytes);
    return head;
  }

  /// Not ours, or of another version: begin anew.
  void discard() {
    close();
    name_.clear();
    if (use_ == Use::labels) unlink(path_.c_str());
  }

  void create(const std::string& model) {
    fs::create_directories(path_.parent_path());
    close();
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) throw Error(ErrorCode::fileUnwritable, std::strerror(errno));
    writable_ = true;
    flock(descriptor_, LOCK_EX);
    if (lseek(descriptor_, 0, SEEK_END) == 0) {  // unless another process was quicker
      ByteWriter head;
      head.raw(magic);
      head.number(version);
      head.text(model.substr(0, maxName));
      if (!writeAll(head.bytes())) {
        const int reason = errno;
        unlink(path_.c_str());
        close();
        throw Error(ErrorCode::fileUnwritable, std::strerror(reason));
      }
    }
    flock(descriptor_, LOCK_UN);
    headBytes_ = headBytes + std::min<std::size_t>(model.size(), maxName);
    name_ = model;
  }

  fs::path path_;
  Use use_;
  int descriptor_ = -1;
  bool writable_ = false;
  std::string name_;
  std::uint64_t headBytes_ = 0;
  std::unordered_map<std::string, std::uint64_t> places_;  ///< key → where its record begins
};

fs::path LabelCache::defaultFolder() {
  return cacheFolder("labels");
}

std::uint64_t LabelCache::defaultLimit() {
  const std::string text = environment("ESTANCIA_CACHE_MB");
  if (text.empty()) return std::uint64_t{2} << 30;
  const double megabytes = io::toNumber(text).value_or(-1);
  if (!(megabytes >= 0 && megabytes < 1e9))
    fail(ErrorCode::invalidOption,
         "ESTANCIA_CACHE_MB is \"{}\"; give the megabytes that cached labels may take", text);
  return static_cast<std::uint64_t>(megabytes * 1e6);
}

LabelCache::LabelCache(fs::path folder, std::uint64_t limit) : folder_(std::move(folder)), limit_(limit) {}

LabelCache::~LabelCache() = default;

LabelCache::File& LabelCache::fileOf(const std::string& model) {
  auto& file = files_[model];
  if (!file) file = std::make_unique<File>(folder_ / (sha256(model).substr(0, 32) + suffix));
  return *file;
}

std::optional<std::string> LabelCache::find(const std::string& model, const std::string& image) {
  const std::string key =
      sha256Bytes(image);  // fingerprints are digests already, but their form is not guaranteed
  const std::lock_guard lock(mutex_);
  return fileOf(model).find(key);
}

void LabelCache::put(const std::string& model, const std::string& image, std::string_view value) {
  const std::string key = sha256Bytes(image);
  const std::lock_guard lock(mutex_);
  if (!problem_.empty()) return;
  try {
    File& file = fileOf(model);
    file.append(model, key, value);
    const std::uint64_t bytes = value.size() + recordHeadBytes;
    untilCheck_ = untilCheck_ > bytes ? untilCheck_ - bytes : 0;
    if (untilCheck_ == 0) {
      makeRoom(file);
      untilCheck_ = std::max<std::uint64_t>(limit_ / 20, 1);
    }
  } catch (const fs::filesystem_error& e) {
    problem_ = notCached(folder_, e.code().message());
  } catch (const std::exception& e) {
    problem_ = notCached(folder_, e.what());
  }
}

void LabelCache::makeRoom(File& current) {
  std::vector<fs::path> files = filesIn(folder_);
  std::uint64_t total = 0;
  for (const fs::path& file : files) total += sizeOf(file);
  while (total > limit_ && !files.empty() && files.back() != current.path()) {
    total -= std::min(total, sizeOf(files.back()));
    std::erase_if(files_, [&](const auto& open) { return open.second->path() == files.back(); });
    fs::remove(files.back());
    files.pop_back();
  }
  if (total > limit_) current.keepNewest(limit_ / 2);
}

std::string LabelCache::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

std::vector<LabelCache::Usage> LabelCache::usage() const {
  std::vector<Usage> all;
  for (const fs::path& path : filesIn(folder_)) {
    const File file(path, File::Use::statistics);
    all.push_back({file.name(), file.images(), sizeOf(path)});
  }
  return all;
}

std::uint64_t LabelCache::clear() {
  const std::lock_guard lock(mutex_);
  files_.clear();
  std::uint64_t freed = 0;
  for (const fs::path& path : filesIn(folder_)) {
    freed += sizeOf(path);
    fs::remove(path);
  }
  return freed;
}

}  // namespace estancia
