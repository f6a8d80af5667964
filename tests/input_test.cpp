#include "rivid/input.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <ctime>
#include <thread>

#include "rivid/data/csv.hpp"
#include "rivid/model/urdf.hpp"
#include "sha256.hpp"
#include "support/complaint.hpp"
#include "support/temporary_folder.hpp"

namespace {

using rivid::read_input;
using rivid::test::complaint_of;
using rivid::test::says;
using Path = std::filesystem::path;

class Input : public testing::Test {
 protected:
  [[nodiscard]] Path in_folder(const std::string& name) const { return folder.path() / name; }
  [[nodiscard]] std::string complaint(const Path& path, bool pipe = false) const {
    return complaint_of([&] { return read_input(path, pipe); });
  }
  rivid::test::TemporaryFolder folder;
};

TEST_F(Input, IsTheContentAndItsDigest) {
  folder.write("a", "abc");
  folder.write("empty", "");
  EXPECT_EQ(read_input(in_folder("a")).bytes(), "abc");
  // The example of FIPS 180-2, B.1.
  EXPECT_EQ(read_input(in_folder("a")).sha256(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(read_input(in_folder("empty")).bytes(), "");
}

// The processor's own instructions against libmd, and both against FIPS 180-4.
TEST(Sha256, IsTheSameWithAndWithoutInstructionsForIt) {
  using rivid::detail::sha256_digits;
  std::string text;
  for (int length = 0; length < 300; ++length) {
    EXPECT_EQ(sha256_digits(text, true), sha256_digits(text, false)) << length;
    text.push_back(static_cast<char>(37 * length + 11));
  }
  for (const bool instructions : {false, true}) {
    EXPECT_EQ(sha256_digits("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq", instructions),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    EXPECT_EQ(sha256_digits(std::string(1'000'000, 'a'), instructions),
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  }
}

TEST_F(Input, IsReadOnceWithinAScope) {
  folder.write("a", "first");
  const rivid::InputScope scope;
  const rivid::InputText before = read_input(in_folder("a"));
  folder.write("a", "second, and longer");
  EXPECT_EQ(read_input(in_folder("./a")).bytes(), "first");
  EXPECT_EQ(rivid::input_sha256(in_folder("a")), before.sha256());
  std::filesystem::remove(in_folder("a"));
  EXPECT_EQ(read_input(in_folder("a")).bytes(), "first");
}

TEST_F(Input, IsReadAnewWithoutAScope) {
  folder.write("a", "first");
  EXPECT_EQ(read_input(in_folder("a")).bytes(), "first");
  folder.write("a", "second");
  EXPECT_EQ(read_input(in_folder("a")).bytes(), "second");
}

TEST_F(Input, IsNotAffectedByAFileThatIsCutLater) {
  folder.write("a", std::string(1 << 20, 'x'));
  const rivid::InputText text = read_input(in_folder("a"));
  std::filesystem::resize_file(in_folder("a"), 0);
  EXPECT_EQ(std::ranges::count(text.bytes(), 'x'), 1 << 20);
}

TEST_F(Input, BeyondWhatIsKeptMayNotChange) {
  const Path large = in_folder("large");
  folder.write("large", "");
  std::filesystem::resize_file(large, std::uintmax_t{65} << 20U);  // a hole
  const rivid::InputScope scope;
  EXPECT_EQ(read_input(large).bytes().size(), std::size_t{65} << 20U);
  EXPECT_EQ(rivid::input_sha256(large).size(), 64U);
  std::filesystem::resize_file(large, std::uintmax_t{66} << 20U);
  EXPECT_TRUE(says(complaint(large), "changed since this program read it"));
}

TEST_F(Input, BeyondWhatIsKeptMayNotShrinkToWhatCouldBeKept) {
  const Path large = in_folder("large");
  folder.write("large", "");
  std::filesystem::resize_file(large, std::uintmax_t{65} << 20U);
  const rivid::InputScope scope;
  EXPECT_EQ(read_input(large).bytes().size(), std::size_t{65} << 20U);
  std::filesystem::resize_file(large, std::uintmax_t{1} << 20U);
  EXPECT_TRUE(says(complaint(large), "changed since this program read it"));
}

TEST_F(Input, ThatIsNoFileIsRefusedAtOnce) {
  ASSERT_EQ(::mkfifo(in_folder("pipe").c_str(), 0600), 0);
  EXPECT_TRUE(says(complaint(in_folder("pipe")), "pipe: is a pipe, a file is required"));
  EXPECT_TRUE(says(complaint(in_folder("pipe"), true), "pipe: is a pipe that nothing came through"));
  EXPECT_TRUE(says(complaint("/dev/zero", true), "/dev/zero: is a device"));
  EXPECT_TRUE(says(complaint(folder.path()), "is a directory, a file is required"));
  EXPECT_TRUE(says(complaint(in_folder("none")), "there is no such file"));
  EXPECT_TRUE(says(complaint_of([&] { return rivid::read_urdf(in_folder("pipe")); }), "is a pipe"));
}

TEST_F(Input, MayBeALogThatComesThroughAPipe) {
  ASSERT_EQ(::mkfifo(in_folder("pipe").c_str(), 0600), 0);
  // Open both ways it waits for nobody, and what is written stays in it until it is read.
  const int pipe = ::open(in_folder("pipe").c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_GE(pipe, 0);
  const std::string text = "t,q1\n0,1\n0.1,2\n";
  ASSERT_EQ(::write(pipe, text.data(), text.size()), std::ssize(text));
  const std::jthread writer([pipe] {
    for (int left = 1; left > 0 && ::ioctl(pipe, FIONREAD, &left) == 0;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ::close(pipe);
  });
  const rivid::Log log = rivid::read_csv(in_folder("pipe"));
  EXPECT_EQ(log.samples(), 2);
}

TEST_F(Input, HasALimit) {
  folder.write("a", std::string(100, 'x'));
  rivid::limit_inputs(99);
  const std::string words = complaint(in_folder("a"));
  rivid::limit_inputs(100);
  const std::string none = complaint(in_folder("a"));
  rivid::limit_inputs(rivid::default_input_limit);
  EXPECT_TRUE(says(words, "the limit of an input; --max-size raises it"));
  EXPECT_EQ(none, "");
}

// Each was quadratic: 16.6 s and 5.4 s before. Of the processor, whatever else the machine does.
double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

TEST_F(Input, OfManyColumnsTakesTimeInProportion) {
  std::string names = "t";
  std::string ones;
  constexpr int columns = 100000;
  for (int i = 1; i <= columns; ++i) {
    names += ",q" + std::to_string(i);
    ones += ",1";
  }
  folder.write("wide.csv", names + "\n0" + ones + "\n1" + ones + "\n");
  const double begin = processor_seconds();
  EXPECT_EQ(rivid::read_csv(in_folder("wide.csv")).joints(), columns);
  EXPECT_LT(processor_seconds() - begin, 3.0);
}

TEST_F(Input, OfManyAttributesTakesTimeInProportion) {
  std::string attributes;
  for (int i = 0; i < 30000; ++i) {
    attributes += " a" + std::to_string(i) + "=\"1\"";
  }
  const std::string urdf = "<robot name=\"r\"" + attributes + "><link name=\"b\"/></robot>";
  const double begin = processor_seconds();
  EXPECT_TRUE(says(complaint_of([&] { return rivid::parse_urdf(urdf, "r.urdf"); }), "no joint moves"));
  EXPECT_LT(processor_seconds() - begin, 2.0);
}

}  // namespace
