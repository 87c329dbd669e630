/* SPDX-License-Identifier: Apache-2.0 */
#ifndef LF_NETWORK_H_
#define LF_NETWORK_H_

/* Waits until the network can be used. Returns 0, or a negative error number when it took too long. */
int network_wait(void);

/*
 * Waits until the others have acknowledged all that was sent to them, and the ends of the connections that were closed,
 * for some seconds at most. Closing a connection does not wait for that, and a program whose network ends with it, as
 * that of native_sim does, would leave others waiting for what was lost on the way.
 */
void network_finish(void);

#endif /* LF_NETWORK_H_ */
