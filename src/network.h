/* SPDX-License-Identifier: Apache-2.0 */
#ifndef LF_NETWORK_H_
#define LF_NETWORK_H_

/* Waits until the network can be used. Returns 0, or a negative error number when it took too long. */
int network_wait(void);

#endif /* LF_NETWORK_H_ */
