// The module that talks through Open MPI (see mpi_processes.hpp).
// SPDX-License-Identifier: Apache-2.0
#define OMPI_SKIP_MPICXX 1
#include <mpi.h>

#include <mutex>
#include <thread>

#include "estancia/processes/mpi_processes.hpp"

namespace estancia {
namespace {

class MpiRanks final : public MpiProcesses {
 public:
  MpiRanks() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
  }
  int rank() const override { return rank_; }
  int size() const override { return size_; }

  void send(int to, const std::string& text) override {
    const std::string sent = text.substr(0, maxBytes);
    wait([&](MPI_Request& request) {
      MPI_Isend(sent.data(), static_cast<int>(sent.size()), MPI_CHAR, to, 0, MPI_COMM_WORLD, &request);
    });
  }

  std::optional<Message> receive(std::chrono::milliseconds patience) override {
    const auto end = std::chrono::steady_clock::now() + patience;
    do {
      {
        const std::lock_guard lock(mutex_);
        int here = 0, size = 0;
        MPI_Status status;
        MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &here, &status);
        if (here != 0) {
          MPI_Get_count(&status, MPI_CHAR, &size);
          Message message{status.MPI_SOURCE, std::string(static_cast<std::size_t>(size), '\0')};
          MPI_Recv(message.text.data(), size, MPI_CHAR, message.from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
          return message;
        }
      }
      rest();
    } while (std::chrono::steady_clock::now() < end);
    return std::nullopt;
  }

  void leave() override {
    wait([](MPI_Request& request) { MPI_Ibarrier(MPI_COMM_WORLD, &request); });
    MPI_Finalize();
  }

 private:
  /// MPI would wait on a busy core that others can use.
  static void rest() { std::this_thread::sleep_for(std::chrono::milliseconds(1)); }

  /// Begins what makes a request, and waits until it is done.
  void wait(const auto& begin) {
    MPI_Request request = MPI_REQUEST_NULL;
    for (int done = 0; done == 0;) {
      {
        const std::lock_guard lock(mutex_);
        if (request == MPI_REQUEST_NULL) begin(request);
        MPI_Test(&request, &done, MPI_STATUS_IGNORE);
      }
      if (done == 0) rest();
    }
  }

  std::mutex mutex_;  // one call at a time: MPI_THREAD_SERIALIZED
  int rank_ = 0, size_ = 1;
};

}  // namespace
}  // namespace estancia

/// Null where MPI does not start, or cannot be used by several threads.
extern "C" __attribute__((visibility("default"))) estancia::MpiProcesses* estanciaJoinRanks() {
  int level = MPI_THREAD_SINGLE;
  if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &level) != MPI_SUCCESS ||
      level < MPI_THREAD_SERIALIZED)
    return nullptr;
  return new estancia::MpiRanks;
}
