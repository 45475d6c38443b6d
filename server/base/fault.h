/** A mark in the file system that says that the program crashed: that it was not killed, and that
 *  the machine did not go down. */
#ifndef VOR_SERVER_BASE_FAULT_H
#define VOR_SERVER_BASE_FAULT_H

/** From here on a signal of the program's own fault (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT,
 *  SIGSYS) leaves a mark of that name, then does what it would have done. One that a stack without
 *  room raises leaves none, nor do processes forked later. Call it again to have another name.
 *
 *  @param[in] mark  a path in a directory that is there, shorter than 4096 bytes */
void vor_fault_arm(const char *mark);

/** Is there a mark, of a former life? */
int vor_fault_left(const char *mark);

/** Removes it. */
void vor_fault_clear(const char *mark);

#endif
