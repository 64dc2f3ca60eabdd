// In this program nothing waits for the disk: a loss of power is simulated (failing_disk.h), and
// what a killed process wrote survives without. On a busy disk the tests would take minutes.
//
// Defined in the program, these precede those of the C library, also for SQLite.
#include <unistd.h>

extern "C" {

int fsync(int /*descriptor*/) { return 0; }

int fdatasync(int /*descriptor*/) { return 0; }
}
