// Of rivid::runtime: text of a file by the standard library alone. rivid::rivid has text_file.cpp, which
// knows of files that the caller provided, and of their checksums.
#include <fstream>
#include <iterator>

#include "experiment/text_file.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

std::string description_text(const std::filesystem::path& path, std::string_view what, std::uintmax_t most) {
  std::ifstream in(path, std::ios::binary);
  std::string out;
  constexpr std::size_t piece = 1U << 16U;  // [bytes] 64 KiB; a choice
  std::size_t filled = 0;
  while (in && filled <= most) {
    out.resize(filled + piece);
    in.read(out.data() + filled, piece);
    filled += static_cast<std::size_t>(in.gcount());
  }
  out.resize(filled);
  if (!in.eof() || filled > most) {
    throw InputError(path.string() + ": " + std::string(what) + " can not be read" +
                     (filled > most ? ": it has more than " + std::to_string(most) + " bytes" : ""));
  }
  return out;
}

}  // namespace rivid::detail
