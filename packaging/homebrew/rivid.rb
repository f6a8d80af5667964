# Installs the tarball of a release of this clone: see packaging/README.md.
class Rivid < Formula
  desc "Identifies the dynamic parameters of robot arms from logs of their motion"
  homepage "https://rivid.invalid"
  url "file://#{File.expand_path("../../build/release/rivid-0.1.0.tar.gz", __dir__)}"
  license "BSD-3-Clause"

  depends_on "cli11" => :build
  depends_on "cmake" => :build
  depends_on "ninja" => :build
  depends_on "nlohmann-json" => :build
  depends_on "tomlplusplus" => :build
  depends_on "eigen"
  depends_on "libmd"
  depends_on :linux
  depends_on "nlopt"
  depends_on "orocos-kdl"
  depends_on "pugixml"
  depends_on "sundials"
  depends_on "urdfdom"

  def install
    system "cmake", "-S", ".", "-B", "build/brew", "-G", "Ninja", "-DBUILD_SHARED_LIBS=ON", "-DCMAKE_UNITY_BUILD=ON",
           "-DRIVID_BUILD_TESTS=OFF", "-DRIVID_BUILD_EXAMPLES=OFF", "-DRIVID_BUILD_BENCHMARKS=OFF", *std_cmake_args
    system "cmake", "--build", "build/brew"
    system "cmake", "--install", "build/brew"
  end

  test do
    assert_match version.to_s, shell_output("#{bin}/rivid --version")
    system bin/"rivid", "demo", "rivid_demo"
  end
end
