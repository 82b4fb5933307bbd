// SPDX-License-Identifier: Apache-2.0
#include "scene_file/mesh_files.hpp"

#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "programs/scratch.hpp"

namespace manylight::scene_file::mesh_files_test {
namespace {

using test::message_of;
using test::Scratch;
using testing::HasSubstr;

constexpr const char* k_square_obj =
    "# a unit square\n"
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    "vt 0 0.25\nvt 1 1\n"
    "vn 0 0 1\n"
    "g ignored\nusemtl ignored\n"
    "f 1/1/1 2/2/1 3/1/1 4/2/1\n";

template <class T>
void put(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

TEST(Obj, ReadsPolygonsAsFansAndSharesVertices) {
  const Scratch scratch;
  const auto path = scratch.write("a.obj", k_square_obj);
  const TriangleMesh<float> mesh = read_obj(path, true);
  ASSERT_EQ(mesh.positions.size(), 4U);
  ASSERT_EQ(mesh.triangles.size(), 2U);
  EXPECT_EQ(mesh.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
  EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
  EXPECT_EQ(mesh.positions[2], Vec3<float>(1, 1, 0));
  EXPECT_EQ(mesh.normals[1], Vec3<float>(0, 0, 1));
  EXPECT_EQ(mesh.uvs[0], Vec2<float>(0, 0.75F)) << "flipped";
  EXPECT_EQ(read_obj(path, false).uvs[0], Vec2<float>(0, 0.25F));
}

TEST(Obj, AcceptsAllFormsOfCornersAndCountsFromTheEnd) {
  const Scratch scratch;
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv +1 1e0 0\nvn 0 0 1\nvt 0 0\n";
  for (const char* face : {"f 1 2 3", "f 1/1 2/1 3/1", "f 1//1 2//1 3//1", "f -3 -2 -1", "f\t1 2 3 \r"}) {
    const TriangleMesh<float> mesh = read_obj(scratch.write("a.obj", vertices + face), true);
    EXPECT_EQ(mesh.positions.size(), 3U) << face;
    EXPECT_EQ(mesh.positions[2], Vec3<float>(1, 1, 0)) << face;
  }
}

TEST(Obj, NamesFileAndLineOfWhatIsWrong) {
  const Scratch scratch;
  const auto error = [&](const std::string& text) {
    return message_of<SceneFileError>([&] { static_cast<void>(read_obj(scratch.write("bad.obj", text), true)); });
  };
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
  EXPECT_THAT(error(vertices + "f 1 2 4\n"), HasSubstr("bad.obj:4: f: vertex index is 4, allowed: 1 to 3"));
  EXPECT_THAT(error(vertices + "f 1 2 0\n"), HasSubstr("index is 0"));
  EXPECT_THAT(error(vertices + "f 1 2 -4\n"), HasSubstr("index is -4"));
  EXPECT_THAT(error(vertices + "f 1/1 2/1 3/1\n"), HasSubstr("texture coordinate index is 1"));
  EXPECT_THAT(error(vertices + "f 1 2\n"), HasSubstr("at least 3 vertices"));
  EXPECT_THAT(error(vertices + "vt 0 0\nvn 0 0 1\nf 1 2 3/1/1/1\n"), HasSubstr("not a corner"));
  EXPECT_THAT(error("v 0 0\n"), HasSubstr("bad.obj:1: v: '' is not a finite number"));
  EXPECT_THAT(error("v 0 nan 0\n"), HasSubstr("'nan' is not a finite number"));
  EXPECT_THAT(error(vertices), HasSubstr("empty mesh"));
  EXPECT_THAT(error(""), HasSubstr("empty mesh"));
  EXPECT_THAT(message_of<SceneFileError>([&] { static_cast<void>(read_obj(scratch / "no.obj", true)); }),
              HasSubstr("no such file"));
}

constexpr const char* k_ply_header =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
    "property float s\nproperty float t\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

std::string binary_ply(bool is_big_endian) {
  std::string body;
  const auto number = [&](auto value) {
    std::string bytes;
    put(bytes, value);
    if (is_big_endian) bytes = std::string(bytes.rbegin(), bytes.rend());
    body += bytes;
  };
  for (const Vec2<float>& p : {Vec2<float>(0, 0), Vec2<float>(1, 0), Vec2<float>(1, 1), Vec2<float>(0, 1)}) {
    for (const float x : {p.x, p.y, 0.5F}) number(x);
    number(std::uint8_t{200});
    number(p.x);
    number(p.y);
  }
  number(std::uint8_t{4});
  for (const std::int32_t index : {0, 1, 2, 3}) number(index);
  const std::string format = is_big_endian ? "binary_big_endian" : "binary_little_endian";
  return "ply\nformat " + format + " 1.0\ncomment x\n" + k_ply_header + body;
}

// Oracle: the same square in the three encodings of the format.
TEST(Ply, ReadsAllThreeEncodings) {
  const Scratch scratch;
  const std::string ascii = std::string("ply\r\nformat ascii 1.0\n") + k_ply_header +
                            "0 0 .5 200 0 0\n1 0 .5 200 1 0\n1 1 .5 200 1 1\n0 1 .5 200 0 1\n4 0 1 2 3\n";
  for (const std::string& text : {ascii, binary_ply(false), binary_ply(true)}) {
    const TriangleMesh<float> mesh = read_ply(scratch.write("a.ply", text), false);
    ASSERT_EQ(mesh.positions.size(), 4U);
    ASSERT_EQ(mesh.triangles.size(), 2U);
    EXPECT_EQ(mesh.positions[2], Vec3<float>(1, 1, 0.5F));
    EXPECT_EQ(mesh.uvs[3], Vec2<float>(0, 1));
    EXPECT_TRUE(mesh.normals.empty());
    EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
  }
}

TEST(Ply, RefusesDamagedFiles) {
  const Scratch scratch;
  const auto error = [&](const std::string& text) {
    return message_of<SceneFileError>([&] { static_cast<void>(read_ply(scratch.write("bad.ply", text), false)); });
  };
  const std::string whole = binary_ply(false);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(error(whole.substr(0, size)), "no error") << "cut to " << size;
  }
  std::string bad_index = whole;
  bad_index[bad_index.size() - 2] = '\x7f';
  EXPECT_THAT(error(bad_index), HasSubstr("face 0: vertex index is"));
  EXPECT_THAT(error("ply\nformat ascii 1.0\nelement vertex 1\nproperty colour x\n"),
              HasSubstr("unknown type 'colour'"));
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 99999999999999\nproperty float x\nproperty float y\n";
  EXPECT_THAT(error(header + "property float z\nend_header\n1 2 3\n"), HasSubstr("truncated PLY data"));
  EXPECT_THAT(error(header + "property float z\nend_header\n1 x 3\n"), HasSubstr("'x' is not a number"));
}

/// A file of two triangles, the second moved by 1 in x, in version 3 or 4.
std::string serialized(std::uint16_t version, std::uint32_t index_of_last_vertex = 2) {
  std::string file;
  std::vector<std::size_t> offsets;
  for (int m = 0; m < 2; ++m) {
    std::string mesh;
    put<std::uint32_t>(mesh, 0x1000U | 0x0002U);  // single precision, texture coordinates
    if (version == 4) mesh += std::string("name") + '\0';
    put<std::uint64_t>(mesh, 3);
    put<std::uint64_t>(mesh, 1);
    for (const float x : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F}) put(mesh, x + static_cast<float>(m));
    for (const float x : {0.F, 0.F, 1.F, 0.F, 0.F, 1.F}) put(mesh, x);
    for (const std::uint32_t i : {0U, 1U, index_of_last_vertex}) put(mesh, i);
    uLongf size = compressBound(static_cast<uLong>(mesh.size()));
    std::string packed(size, '\0');
    compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(mesh.data()),
             static_cast<uLong>(mesh.size()));
    packed.resize(size);
    offsets.push_back(file.size());
    put<std::uint16_t>(file, 0x041C);
    put(file, version);
    file += packed;
  }
  for (const std::size_t offset : offsets) {
    if (version == 4)
      put(file, static_cast<std::uint64_t>(offset));
    else
      put(file, static_cast<std::uint32_t>(offset));
  }
  put<std::uint32_t>(file, 2);
  return file;
}

TEST(Serialized, ReadsBothVersionsAndEveryMesh) {
  const Scratch scratch;
  for (const std::uint16_t version : {std::uint16_t{3}, std::uint16_t{4}}) {
    const auto path = scratch.write("a.serialized", serialized(version));
    const TriangleMesh<float> second = read_serialized(path, 1);
    ASSERT_EQ(second.positions.size(), 3U);
    EXPECT_EQ(second.positions[1], Vec3<float>(2, 1, 1));
    EXPECT_EQ(second.uvs[2], Vec2<float>(0, 1)) << "not flipped";
    EXPECT_EQ(second.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
    EXPECT_EQ(read_serialized(path, 0).positions[1], Vec3<float>(1, 0, 0));
    EXPECT_THAT(message_of<SceneFileError>([&] { static_cast<void>(read_serialized(path, 2)); }),
                HasSubstr("shape_index is 2, allowed: 0 to 1"));
  }
}

TEST(Serialized, RefusesDamagedFiles) {
  const Scratch scratch;
  const std::string whole = serialized(4);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto path = scratch.write("cut.serialized", whole.substr(0, size));
    EXPECT_NE(message_of<SceneFileError>([&] { static_cast<void>(read_serialized(path, 1)); }), "no error") << size;
  }
  std::string wild = whole;
  for (std::size_t i = 4; i < 20; ++i) wild[wild.size() - 1 - i] = '\xff';  // the table of offsets
  const auto path = scratch.write("wild.serialized", wild);
  EXPECT_THAT(message_of<SceneFileError>([&] { static_cast<void>(read_serialized(path, 0)); }),
              HasSubstr("mesh table is damaged"));
}

// Oracle: one triangle, moved by its node; the buffer is the bytes of three indices and three corners in base 64.
TEST(Gltf, ReadsMeshesMovedByTheirNodes) {
  const Scratch scratch;
  const std::string buffer = "AAABAAIAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAACAPwAAAAA=";
  const auto path = scratch.write(
      "a.gltf",
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"translation":[0,0,5]}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":1},"indices":0}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5123,"count":3,"type":"SCALAR"},)"
      R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":6},{"buffer":0,"byteOffset":8,"byteLength":36}],)"
      R"("buffers":[{"byteLength":44,"uri":"data:application/octet-stream;base64,)" +
          buffer + R"("}]})");
  const TriangleMesh<float> mesh = read_gltf(path, true);
  ASSERT_EQ(mesh.positions.size(), 3U);
  ASSERT_EQ(mesh.triangles.size(), 1U);
  EXPECT_EQ(mesh.positions[mesh.triangles[0][1]], Vec3<float>(1, 0, 5));
  EXPECT_NE(message_of<SceneFileError>([&] { static_cast<void>(read_gltf(scratch.write("b.gltf", "{"), true)); }),
            "no error");
}

}  // namespace
}  // namespace manylight::scene_file::mesh_files_test
