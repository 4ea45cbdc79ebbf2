from workbench.gateways.monitor.picture import Camera
from workbench.link import Client

POSITION = (1.0, 2.0, 3.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0)


class Clock:
    def __init__(self, now):
        self.now = now

    def __call__(self):
        return self.now


def test_a_picture_has_the_newest_the_rate_and_the_age(server, fakes):
    clock, wall = Clock(100.0), Clock(7_004_000_000)
    with Client(server.address) as client:
        camera = Camera(client, server.address, clock, wall)
        first = camera.picture()
        assert (first.samples, first.time, first.age, first.rate) == ({}, None, None, 0.0)
        for number in range(10):
            server.publish(number, time_data=(0, number, 7_000_000_000), position_data=POSITION)
        fakes.wait_until(lambda: client.received == 20)
        clock.now += 2.0
        picture = camera.picture()
        assert picture.rate == 10.0
        assert picture.age == 0.004
        assert picture.samples["position_data"].t_ns == 9
        assert picture.trouble == ""
        clock.now += 0.5
        assert camera.picture().rate == 10.0  # stays for a second
        clock.now += 1.0
        assert camera.picture().rate == 0.0


def test_bars_end_at_the_strongest_thrust_so_far(server, fakes):
    with Client(server.address) as client:
        camera = Camera(client, server.address)
        ends = []
        for at, thrust in enumerate((2.0, 8.0, 1.0), start=1):
            server.publish(at, rotors=((0.0,) * 4, (thrust, 2.0, 2.0, 2.0)))
            fakes.wait_until(lambda at=at: client.received == at)
            ends.append(camera.picture().strongest)
        assert ends == [3.0, 8.0, 8.0]


def test_who_flies_is_known_by_the_number_of_the_connection(server, fakes):
    with Client(server.address, name="me") as client:
        camera = Camera(client, server.address)
        with client.control():
            fakes.wait_until(lambda: client.control_state)
            assert camera.picture().mine
        server.say(server.nobody("released"))
        fakes.wait_until(lambda: client.control_state.reason == "released")
        assert not camera.picture().mine
