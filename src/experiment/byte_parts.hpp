#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/json_fields.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/log_factors.hpp"

// Files of factors: eight letters, version and order of the bytes, a description as JSON, parts with their
// lengths, and a checksum. All values are little-endian, whatever the machine.
namespace rivid::detail {

/// Writes such a content.
class PartWriter {
 public:
  /// @param magic  eight letters
  PartWriter(std::string_view magic, std::uint32_t version, const Json& description);

  /// The factors of joints.
  template <typename Group>
  void put(const std::vector<Group>& groups) {
    for (const Group& group : groups) {
      put_part(encoded(group.qr));
    }
  }

  [[nodiscard]] std::string content() &&;

 private:
  void put_part(std::string_view part);

  std::string out_;
};

/// Reads what a PartWriter wrote.
class PartReader {
 public:
  /// @param holds   what it must be, for messages: "holds no factors of logs"
  /// @param source  a name for messages
  /// @throws InputError  where it is another kind of content, of another version, truncated or damaged
  PartReader(std::string_view content, std::string_view magic, std::uint32_t version, std::string_view holds,
             std::string_view source);

  [[nodiscard]] InputError fault(const std::string& what) const;

  /// @throws Json::exception
  [[nodiscard]] const Json& description() const { return description_; }

  /// A number of parts in the description.
  ///
  /// @throws InputError  where it is above `most`
  [[nodiscard]] Index count(const char* key, Index most) const;

  /// Columns that the factors of each joint touch.
  ///
  /// @throws InputError  where they are not ascending
  [[nodiscard]] std::vector<std::vector<Index>> columns() const;

  /// The next factors of joints with these columns.
  ///
  /// @param carried  columns of a joint with so many of its own
  template <typename Group, std::invocable<Index> Carried>
  [[nodiscard]] std::vector<Group> groups(const std::vector<std::vector<Index>>& columns,
                                          const Carried& carried) {
    std::vector<Group> out;
    for (const std::vector<Index>& own : columns) {
      out.push_back({own, decoded_streaming_qr(part(), source_)});
      if (out.back().qr.columns() != std::ssize(own) || out.back().qr.carried() != carried(std::ssize(own))) {
        throw fault("is damaged: a factor has other columns than its joint");
      }
    }
    return out;
  }

  /// @throws InputError  where there is more
  void expect_end() const;

 private:
  template <typename Number>
  Number number();
  std::string_view part();
  std::string_view take(std::uint64_t count);

  std::string_view content_;
  std::string_view source_;
  Json description_;
};

}  // namespace rivid::detail
