// SPDX-License-Identifier: Apache-2.0
#include "estancia/fetch/archive.hpp"

#include <archive.h>
#include <archive_entry.h>

#include <array>
#include <memory>
#include <string_view>

#include "estancia/core/fail.hpp"
#include "estancia/fetch/partial_file.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

using Archive = std::unique_ptr<archive, decltype(&archive_read_free)>;

[[noreturn]] void failDamaged(const fs::path& path, archive* reader) {
  const char* reason = archive_error_string(reader);
  fail(ErrorCode::malformedFile, "{}: no archive, or damaged ({}); fetch it again", path.string(),
       reason == nullptr ? "unknown reason" : reason);
}

bool isCalled(archive_entry* entry, std::string_view name) {
  const char* path = archive_entry_pathname(entry);
  if (path == nullptr || archive_entry_filetype(entry) != AE_IFREG) return false;
  const std::string_view full(path);
  return full == name ||
         (full.size() > name.size() && full.ends_with(name) && full[full.size() - name.size() - 1] == '/');
}

}  // namespace

bool extractMember(const fs::path& path, const std::string& name, const fs::path& target,
                   std::uint64_t maxBytes) {
  const Archive reader(archive_read_new(), &archive_read_free);
  // Not all that libarchive knows: some filters start programs.
  archive_read_support_filter_gzip(reader.get());
  archive_read_support_filter_bzip2(reader.get());
  archive_read_support_filter_xz(reader.get());
  archive_read_support_filter_zstd(reader.get());
  archive_read_support_format_tar(reader.get());
  archive_read_support_format_zip(reader.get());
  if (archive_read_open_filename(reader.get(), path.c_str(), 1 << 16) != ARCHIVE_OK)
    failDamaged(path, reader.get());
  archive_entry* entry = nullptr;
  int code = ARCHIVE_OK;
  while ((code = archive_read_next_header(reader.get(), &entry)) == ARCHIVE_OK || code == ARCHIVE_WARN) {
    if (!isCalled(entry, name)) continue;
    PartialFile part(target);
    part.restart(path.string(), "");
    std::array<char, 1 << 16> block{};
    la_ssize_t count = 0;
    while ((count = archive_read_data(reader.get(), block.data(), block.size())) > 0) {
      if (part.size() + static_cast<std::uint64_t>(count) > maxBytes) {
        part.restart("", "");
        fail(ErrorCode::tooLarge, "{}: {} in it is longer than the {} bytes allowed", path.string(), name,
             maxBytes);
      }
      part.append({block.data(), static_cast<std::size_t>(count)});
    }
    if (count < 0) {
      part.restart("", "");
      failDamaged(path, reader.get());
    }
    part.finish();
    return true;
  }
  if (code != ARCHIVE_EOF) failDamaged(path, reader.get());
  return false;
}

}  // namespace estancia
