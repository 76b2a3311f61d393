#pragma once
#define TIOCOUTQ 0x5411
int ioctl(int file, int request, ...);
