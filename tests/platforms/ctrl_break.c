/* Starts a command in its own console, sends Ctrl-Break to it after so many milliseconds, and ends with its exit code.
 *
 *     ctrl_break.exe MILLISECONDS COMMAND...
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

/* The event reaches everybody at the console: it is not meant for this process. */
static BOOL WINAPI ignore(DWORD event)
{
    return event == CTRL_BREAK_EVENT;
}

int main(int argc, char **argv)
{
    static char line[8192];
    STARTUPINFOA start = {.cb = sizeof start};
    PROCESS_INFORMATION child;
    DWORD code = 255;
    for (int i = 2; i < argc; i++) {
        strcat(line, argv[i]);
        strcat(line, " ");
    }
    SetConsoleCtrlHandler(ignore, TRUE);
    if (argc < 3 || !CreateProcessA(NULL, line, NULL, NULL, TRUE, 0, NULL, NULL, &start, &child)) {
        fprintf(stderr, "ctrl_break: cannot start %s: error %lu\n", line, GetLastError());
        return 254;
    }
    Sleep(atoi(argv[1]));
    if (!GenerateConsoleCtrlEvent(CTRL_BREAK_EVENT, 0)) {
        fprintf(stderr, "ctrl_break: not sent: error %lu\n", GetLastError());
        return 252;
    }
    if (WaitForSingleObject(child.hProcess, 10000) != WAIT_OBJECT_0) {
        fprintf(stderr, "ctrl_break: it has not ended within 10 s\n");
        TerminateProcess(child.hProcess, 253);
        WaitForSingleObject(child.hProcess, 1000);
    }
    GetExitCodeProcess(child.hProcess, &code);
    return (int)code;
}
