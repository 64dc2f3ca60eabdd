#include "device/usb/driver/board_survey.h"

#include "device/usb/driver/board_names.h"

#include <fmt/format.h>

namespace springdrive::usb {

std::string sysfs_name_of(int bus, std::span<const std::uint8_t> ports) {
    if (ports.empty()) {
        return fmt::format("usb{}", bus); // the computer's own hub
    }
    return fmt::format("{}-{}", bus, fmt::join(ports, "."));
}

void take_identity(std::span<const std::uint8_t> answer, SurveyedBoard &board) {
    Identity identity;
    const FrameStatus status = decode(answer.data(), answer.size(), identity);
    if (status != FrameStatus::ok) {
        board.obstacle = BoardObstacle::no_interface;
        board.problem = fmt::format("cannot be asked for its identity: {}; is it a board for "
                                    "springdrive?",
                                    answer.empty() ? "it refuses" : description_of(status));
        return;
    }
    board.serial = text_of(identity.serial);
    board.firmware = fmt::format("{} {}.{}.{}", text_of(identity.name), identity.firmware[0],
                                 identity.firmware[1], identity.firmware[2]);
    if (kProtocolVersion < identity.oldest_version || kProtocolVersion > identity.newest_version) {
        board.obstacle = BoardObstacle::wrong_version;
        board.problem =
            fmt::format("has versions {} to {} of the protocol, this program has "
                        "version {}; install the firmware or the program that fits "
                        "the other",
                        identity.oldest_version, identity.newest_version, kProtocolVersion);
    }
}

} // namespace springdrive::usb
