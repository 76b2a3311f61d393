#pragma once
typedef int pid_t;
pid_t gettid(void);
long syscall(long number, ...);
