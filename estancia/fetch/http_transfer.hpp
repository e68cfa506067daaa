// HTTP transfer: one GET request whose answer goes to a partial file.
#pragma once

#include <memory>
#include <string>

#include "estancia/fetch/download.hpp"
#include "estancia/fetch/partial_file.hpp"

namespace estancia {

/// How a request ended.
struct TransferResult {
  enum class End {
    complete,  ///< the server says that this was all
    broken,    ///< it may be gone on with
    misfit,    ///< the server has no such rest: begin anew
    refused,   ///< no use in asking again
  };
  End end = End::complete;
  std::string reason;    ///< why it is not complete, for people
  bool resumed = false;  ///< bytes were added to what was there before
  int retryAfter = 0;    ///< seconds that the server asks to wait
};

/// Asks for `url` and writes what comes to `part`; with `resume` for the rest of what `part` holds, which the
/// server may answer with all of it. Refuses what has not file.size bytes. Throws Interrupted, and what
/// `part` throws.
TransferResult transfer(const std::string& url, bool resume, const RemoteFile& file, PartialFile& part,
                        Progress& progress, const DownloadOptions& options);

}  // namespace estancia
