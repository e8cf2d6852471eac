"""SimulatedMotorBoard: a motor board for systems without a real one, in this process or another."""

from __future__ import annotations

from collections import deque
from typing import Protocol

from refnav.base_control import start_of
from refnav.motor_board import MotorBoard
from refrobots.components.simulated_motor_board import SimulatedMotorBoardBase
from refrobots.rh3 import BoardEvent, BoardEventKind
from refrobots.tecs.board.motor_board_codec import MotorBoardCodec
from refrobots.tecs.board.motor_board_server import MotorBoardUnmarshaller
from rtgen.runtime import RTC_OK, ReturnCode_t
from rtgen.runtime.opaque_rpc import (
    ChannelError,
    SerialServer,
    SimulatedServer,
    TcpServer,
)


class Server(Protocol):
    """Serves the board's calls until it is closed."""

    def close(self) -> None: ...


class SimulatedMotorBoard(SimulatedMotorBoardBase):
    """A board switched on by the first activation, and reachable while ACTIVE.

    Its observables are `truth`, the true pose (x, y, theta) [m, rad], and `wheels`, the speeds of
    the left and the right wheel [rad/s]; both are empty if another process has the board.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Publish the pose of the base."""
        self._board: MotorBoard | None = None
        self._server: Server | None = None
        self._log: deque[BoardEvent] = deque()
        self.observables["truth"] = self._truth
        self.observables["wheels"] = self._wheels
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Switch the board on, and accept connections."""
        config = self.config
        if config.transport == "none":
            return RTC_OK
        if self._board is None:
            self._board = MotorBoard(
                config, start_of(config), self.now, self._log.append
            )
        return self._listen(self._board) if config.link else RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Hold the wheels, and close the connections."""
        self._leave()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Hold the wheels, and close the connections."""
        self._leave()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Cut or restore the connection, run the board's loop, and send its log."""
        board = self._board
        if board is None:
            return RTC_OK
        code = RTC_OK
        if self.config.link != (self._server is not None):
            if self._server is not None:
                self._close()
                board.note(BoardEventKind.LINK_DOWN)
            elif (code := self._listen(board)) is RTC_OK:
                board.note(BoardEventKind.LINK_UP)
        board.turn()
        while self._log:
            self.events.write(self._log.popleft())
        return code

    def _listen(self, board: MotorBoard) -> ReturnCode_t:
        try:
            self._server = self._opened(
                MotorBoardUnmarshaller(board, MotorBoardCodec())
            )
        except (OSError, ChannelError) as error:
            return self.fail(f"cannot listen: {error}")
        return RTC_OK

    def _opened(self, service: MotorBoardUnmarshaller) -> Server:
        config = self.config
        serial = config.transport == "serial"
        if self.network is not None:
            address = config.device if serial else f"{config.host}:{config.port}"
            return SimulatedServer(self.network, address, service)
        server = (
            SerialServer(service, config.device, config.baudrate)
            if serial
            else TcpServer(service, config.host, config.port)
        )
        server.start()
        return server

    def _close(self) -> None:
        server, self._server = self._server, None
        if server is not None:
            server.close()

    def _leave(self) -> None:
        self._close()
        if self._board is not None:
            self._board.base.halt()

    def _truth(self) -> tuple[float, ...]:
        return () if self._board is None else self._board.base.pose

    def _wheels(self) -> tuple[float, ...]:
        return () if self._board is None else tuple(self._board.base.speeds)
