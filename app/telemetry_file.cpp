#include "app/telemetry_file.h"

#include "base/input_error.h"

namespace springdrive {

TelemetryFile::TelemetryFile(const std::filesystem::path &path) : path_(path), stream_(path) {
    if (!stream_) {
        throw InputError(path.string() + ": cannot be written; check its folder and permissions");
    }
    stream_ << telemetry_header() << '\n';
}

void TelemetryFile::write(const ServoSample &sample) {
    stream_ << telemetry_row(sample) << '\n';
    if (!stream_) {
        throw InputError(path_.string() + ": telemetry ends after " + std::to_string(rows_) +
                         " rows: the disk takes no more");
    }
    ++rows_;
}

void TelemetryFile::close() {
    stream_.close();
    if (!stream_) {
        throw InputError(path_.string() + ": telemetry is incomplete: the disk takes no more");
    }
}

} // namespace springdrive
