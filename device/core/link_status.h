// The connection to a device, for display.
#pragma once

#include <cstdint>
#include <string>

namespace springdrive::device {

struct LinkStatus {
    std::string speed;         ///< "high speed (480 Mbit/s)"
    std::string board_state;   ///< "driving"
    std::string remark;        ///< what the system refused to the link; empty if nothing
    std::string last_problem;  ///< of a packet, in words; empty if there was none
    double report_rate_hz = 0; ///< requested

    // Of the latest ones; 0 until they are known.
    double delay_s = 0.0;              ///< d T, mean
    double longest_delay_s = 0.0;      ///< d T
    double round_trip_s = 0.0;         ///< of packets alone, mean
    double longest_round_trip_s = 0.0; ///< the same

    // Since the connection.
    std::uint64_t reports = 0;  ///< valid and new
    std::uint64_t lost = 0;     ///< reports whose numbers are missing
    std::uint64_t late = 0;     ///< ticks whose newest report was measured for an earlier one
    std::uint64_t absent = 0;   ///< ticks without a new report
    std::uint64_t repeated = 0; ///< reports that came twice
    std::uint64_t stale = 0;    ///< reports that came after newer ones
    std::uint64_t corrupt = 0;  ///< packets that are no valid report
    std::uint64_t unsent = 0;   ///< commands that could not be sent
    std::uint64_t rejected = 0; ///< packets that the board rejected
};

} // namespace springdrive::device
