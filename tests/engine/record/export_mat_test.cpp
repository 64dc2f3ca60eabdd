// Covers engine/record/export_mat.cpp, by the library's reader and byte by byte.
#include "engine/record/record_export.h"

#include "tests/engine/record/record_bytes.h"
#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>
#include <matio.h>

#include <cmath>
#include <map>
#include <sys/mount.h>

namespace springdrive::record {
namespace {

using testing::contents_of;
using testing::error_text_of;
using testing::fresh_folder;

struct MatVariable {
    matio_classes of_array = MAT_C_EMPTY;
    std::size_t rows = 0;
    std::size_t columns = 0;
    std::string data;
};

std::map<std::string, MatVariable> read_mat(const std::filesystem::path &file) {
    std::map<std::string, MatVariable> variables;
    mat_t *const mat = Mat_Open(file.c_str(), MAT_ACC_RDONLY);
    EXPECT_NE(mat, nullptr);
    while (matvar_t *const v = mat == nullptr ? nullptr : Mat_VarReadNext(mat)) {
        EXPECT_EQ(v->rank, 2);
        const std::size_t bytes = v->dims[0] * v->dims[1] * Mat_SizeOfClass(v->class_type);
        variables[v->name] = {v->class_type, v->dims[0], v->dims[1],
                              std::string(static_cast<const char *>(v->data), bytes)};
        Mat_VarFree(v);
    }
    Mat_Close(mat);
    return variables;
}

TEST(ExportMat, PreservesEveryBitOfAllColumns) {
    const auto folder = fresh_folder("mat");
    // 1 to 4 rows of a byte are stored differently from 5.
    for (const std::size_t rows : {1U, 2U, 4U, 5U, 57U}) {
        const auto samples = testing::random_samples(rows, 1000.0, rows);
        const auto file = folder / (std::to_string(rows) + ".rec");
        testing::write_record(file, 1000.0, samples);
        RecordReader reader(file);
        EXPECT_EQ(export_mat(reader, {}, folder / "a.mat", Existing::replace).rows, rows);
        EXPECT_NE(error_text_of([&] { (void)export_mat(reader, {}, folder / "a.mat"); }), "");
        const auto variables = read_mat(folder / "a.mat");
        EXPECT_EQ(variables.size(), reader.header().columns.size());
        for (const RecordColumn &column : reader.header().columns) {
            const MatVariable &variable = variables.at(column.name);
            std::string expected;
            for (const servo::ServoSample &sample : samples) {
                expected += testing::row_of(sample).substr(column.offset, bytes_of(column.type));
            }
            EXPECT_EQ(variable.rows, rows) << column.name;
            EXPECT_EQ(variable.columns, 1U) << column.name;
            EXPECT_EQ(variable.data, expected) << column.name;
        }
        EXPECT_EQ(variables.at("tick").of_array, MAT_C_UINT64);
        EXPECT_EQ(variables.at("triangle").of_array, MAT_C_UINT32);
        EXPECT_EQ(variables.at("material").of_array, MAT_C_UINT16);
        EXPECT_EQ(variables.at("map").of_array, MAT_C_UINT8);
        EXPECT_EQ(variables.at("counts1").of_array, MAT_C_INT32);
        EXPECT_EQ(variables.at("tip_x_m").of_array, MAT_C_DOUBLE);
    }
}

// MATLAB's "Level 5 MAT-File Format": a variable of two ticks, element by element.
TEST(ExportMat, FollowsTheFormatDescription) {
    const auto folder = fresh_folder("mat_by_hand");
    auto samples = testing::random_samples(2, 1000.0, 1);
    samples[0].tick = 0x0102030405060708U;
    samples[1].tick = 9;
    testing::write_record(folder / "a.rec", 1000.0, samples);
    RecordReader reader(folder / "a.rec");
    (void)export_mat(reader, {{"tick"}}, folder / "a.mat");
    const std::string bytes = contents_of(folder / "a.mat");
    const auto number = [&](std::size_t at) { return testing::number_at(bytes, at, 4); };
    EXPECT_EQ(bytes.substr(0, 10), "MATLAB 5.0");
    EXPECT_EQ(bytes.substr(124, 4), std::string("\0\1IM", 4));
    EXPECT_EQ(number(128), 14U); // miMATRIX
    EXPECT_EQ(number(132), bytes.size() - 136);
    EXPECT_EQ(number(136), 6U); // flags, miUINT32
    EXPECT_EQ(number(140), 8U);
    EXPECT_EQ(number(144) & 0xFFU, 15U); // mxUINT64_CLASS
    EXPECT_EQ(number(152), 5U);          // dimensions, miINT32
    EXPECT_EQ(number(156), 8U);
    EXPECT_EQ(number(160), 2U);
    EXPECT_EQ(number(164), 1U);
    EXPECT_EQ(number(168), 0x00040001U); // name, miINT8, 4 bytes, in its tag
    EXPECT_EQ(bytes.substr(172, 4), "tick");
    EXPECT_EQ(number(176), 13U); // miUINT64
    EXPECT_EQ(number(180), 16U);
    EXPECT_EQ(testing::number_at(bytes, 184, 8), 0x0102030405060708U);
    EXPECT_EQ(testing::number_at(bytes, 192, 8), 9U);
    EXPECT_EQ(bytes.size(), 200U);
}

TEST(ExportMat, ExportsATimeRangeEvenAnEmptyOne) {
    const auto folder = fresh_folder("mat_range");
    testing::write_record(folder / "a.rec", 250.0, testing::random_samples(30, 250.0, 2));
    RecordReader reader(folder / "a.rec");
    EXPECT_EQ(export_mat(reader, {{"time_s"}, 0.02, 0.1}, folder / "a.mat").rows, 21U);
    EXPECT_EQ(read_mat(folder / "a.mat").at("time_s").rows, 21U);
    EXPECT_EQ(export_mat(reader, {{"time_s", "map"}, 7.0, 8.0}, folder / "b.mat").rows, 0U);
    const auto empty = read_mat(folder / "b.mat");
    EXPECT_EQ(empty.size(), 2U);
    EXPECT_EQ(empty.at("time_s").rows, 0U);
}

TEST(ExportMat, NamesAFileThatCannotBeWritten) {
    const auto folder = fresh_folder("mat_none");
    testing::write_record(folder / "a.rec", 250.0, testing::random_samples(3, 250.0, 2));
    RecordReader reader(folder / "a.rec");
    const auto file = folder / "none" / "a.mat";
    const std::string said = error_text_of([&] { (void)export_mat(reader, {}, file); });
    EXPECT_EQ(said.find(file.string() + ": cannot be written"), 0U) << said;
}

TEST(ExportMat, LeavesNoFileOnAFullDisk) {
    const auto folder = fresh_folder("mat_full");
    testing::write_record(folder / "a.rec", 1000.0, testing::random_samples(900, 1000.0, 3));
    std::filesystem::create_directory(folder / "disk");
    if (mount("none", (folder / "disk").c_str(), "tmpfs", 0, "size=256k") != 0) {
        GTEST_SKIP() << "mounting a small disk takes root";
    }
    RecordReader reader(folder / "a.rec");
    const auto file = folder / "disk" / "a.mat";
    const std::string said = error_text_of([&] { (void)export_mat(reader, {}, file); });
    EXPECT_EQ(said.find(file.string() + ": cannot be written"), 0U) << said;
    EXPECT_FALSE(std::filesystem::exists(file));
    umount((folder / "disk").c_str());
}

} // namespace
} // namespace springdrive::record
