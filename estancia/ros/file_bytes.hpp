// File bytes: a file that is read by position, so that one that shrinks meanwhile is an error and no crash.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace estancia::ros {

/// A regular file, opened for reading. Reading is thread-safe.
class FileBytes {
 public:
  /// Throws Error: fileNotFound, fileUnreadable, unsupportedFile (a folder, a device …).
  explicit FileBytes(const std::filesystem::path& path);
  /// Takes an open file over; `name` is what messages call it.
  FileBytes(int file, std::string name);
  FileBytes(FileBytes&& other) noexcept;
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;
  FileBytes& operator=(FileBytes&& other) noexcept;
  ~FileBytes();

  /// Size when the file was opened [bytes].
  std::uint64_t size() const { return size_; }
  /// For messages; printable.
  const std::string& name() const { return name_; }
  /// Fills `into`. Throws Error: truncatedFile when the file has become shorter, fileUnreadable.
  void read(std::uint64_t offset, std::span<std::byte> into) const;

 private:
  int file_;
  std::string name_;
  std::uint64_t size_ = 0;
};

/// Bytes that a parser walks over, by position.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::uint64_t size() const = 0;
  /// `count` bytes, valid until the next call; nothing where fewer are there.
  virtual std::optional<std::string_view> at(std::uint64_t offset, std::uint64_t count) = 0;

  /// The little-endian number at `offset`.
  template <class Value>
  std::optional<Value> numberAt(std::uint64_t offset) {
    static_assert(std::is_arithmetic_v<Value>);
    const auto bytes = at(offset, sizeof(Value));
    if (!bytes) return std::nullopt;
    Value value{};
    std::memcpy(&value, bytes->data(), sizeof value);
    return value;
  }
};

class MemorySource : public ByteSource {
 public:
  explicit MemorySource(std::span<const std::byte> bytes)
      : bytes_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}
  std::uint64_t size() const override { return bytes_.size(); }
  std::optional<std::string_view> at(std::uint64_t offset, std::uint64_t count) override {
    if (offset > bytes_.size() || count > bytes_.size() - offset) return std::nullopt;
    return bytes_.substr(offset, count);
  }

 private:
  std::string_view bytes_;
};

/// A stretch of a file, of which it reads a little at a time: what is jumped over costs nothing.
class FileSource : public ByteSource {
 public:
  explicit FileSource(const FileBytes& file) : FileSource(file, 0, file.size()) {}
  FileSource(const FileBytes& file, std::uint64_t begin, std::uint64_t size)
      : file_(file), begin_(begin), size_(size) {}
  std::uint64_t size() const override { return size_; }
  std::optional<std::string_view> at(std::uint64_t offset, std::uint64_t count) override;

 private:
  const FileBytes& file_;
  std::uint64_t begin_, size_;
  std::uint64_t windowAt_ = 0;
  std::vector<std::byte> window_;
};

}  // namespace estancia::ros
