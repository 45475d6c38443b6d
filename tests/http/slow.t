#!/usr/bin/perl
# Those who take their time, send too much, or too little.
use strict;
use warnings;
use FindBin;
use IO::Select;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $daemon = Vt->start('header-timeout' => 1, 'keep-timeout' => 1, 'body-idle' => 3, 'body-rate' => '1K', 'body-limit' => '64M');
my $host = "Host: localhost\r\n";
my $post = "POST /v1/resample?points=10 HTTP/1.1\r\n$host";
my $chunked = "${post}Transfer-Encoding: chunked\r\nConnection: close\r\n\r\n";
my $chunk = sprintf "%x\r\n%s\r\n", 8192, 'x' x 8192;

# One who begins with these bytes and sends the others again and again.
sub peer { my ($daemon, $begin, $again) = @_; my $socket = $daemon->connect; $socket->syswrite($begin); return { socket => $socket, again => $again, got => '' } }

# Lets all of them send until the daemon has closed the connections of the first so many.
sub until_closed {
    my ($count, @peers) = @_;
    my $select = IO::Select->new(map { $_->{socket} } @peers);

    local $SIG{PIPE} = 'IGNORE';
    return wait_until(sub {
        my %ready = map { $_ => 1 } $select->can_read(0.2);
        for my $peer (grep { !$_->{closed} } @peers) {
            if ($ready{ $peer->{socket} } && !$peer->{socket}->sysread($peer->{got}, 65536, length $peer->{got})) {
                $peer->{closed} = 1;
                $select->remove($peer->{socket});
            } else {
                $peer->{socket}->syswrite($peer->{again});
            }
        }
        return $count == grep { $_->{closed} } @peers[0 .. $count - 1];
    });
}

# They are cut, each by its own limit, while one who is quick enough goes on for as long as all of them.
my ($head, $line, $kept, $stops, $drips, $good) = my @peers = map { peer($daemon, @$_) } ['', 'x'], ["GET /livez HTTP/1.1\r\n", 'x'],
    ["GET /livez HTTP/1.1\r\n$host\r\n", ''], (map { ["${post}Content-Length: 1000\r\n\r\nply", $_] } '', 'x'), [$chunked, $chunk];
ok until_closed(5, @peers), 'whoever is slow is cut';
is $head->{got} . $line->{got}, '', 'a head that drips, however steady, also after its first line';
like $kept->{got}, qr{\AHTTP/1\.1 200 .*alive}s, 'a kept connection that stays silent, after its answer';
like $stops->{got}, qr{\AHTTP/1\.1 408 .*"type":"[^"]*/upload-timeout"}s, 'a body that stops, with a 408';
like $_->{got}, qr{^Date: \w{3}, \d\d \w{3} \d{4} \d\d:\d\d:\d\d GMT\r\n(?:.*\n)*X-Content-Type-Options: nosniff\r}m, 'with a date'
    for $stops, $drips;
like $drips->{got}, qr{\AHTTP/1\.1 408 .*"retryable":true}s, 'a body that drips below the rate, with a 408';
is $good->{got}, '', 'whoever is not is not cut';
$good->{socket}->syswrite("0\r\n\r\n");
like Vt::read_all($good->{socket}), qr{\AHTTP/1\.1 415 }, 'and has its answer';
sub late { return scalar grep { ($_->{status} // '') eq '408' && $_->{problem} eq 'upload-timeout' } $daemon->log_lines }
ok wait_until(sub { late() == 2 }), 'the log says 408 of both';

my $strict = Vt->start('body-timeout' => 1);
my $steady = peer($strict, $chunked, $chunk);
ok until_closed(1, $steady), 'a body that takes too long is cut, however steady';
like $steady->{got}, qr{\AHTTP/1\.1 408 .*/upload-timeout"}s, 'with a 408';
is $strict->stop, 0, 'it ends with 0';

# Too much, told at once.
my $early = $daemon->raw("${post}Content-Length: 70000000\r\n\r\n");
like $early, qr{\AHTTP/1\.1 413 .*"limit":67108864,"got":70000000}s,
    'a body too long is refused before it is sent';
my $continue = $daemon->raw("${post}Content-Length: 70000000\r\nExpect: 100-continue\r\n\r\n");
like $continue, qr{\AHTTP/1\.1 413 }, 'who asks first is not told to continue';
my $asked = $daemon->connect;
$asked->print("${post}Content-Length: 10\r\nExpect: 100-continue\r\n\r\n");
$asked->flush;
like Vt::read_all($asked, qr/\r\n/), qr{\AHTTP/1\.1 100 }, 'unless the body is welcome';
close $asked;
my $large = Vt->start('body-limit' => '100K');
my $answer = $large->post('/v1/resample?points=10', 'x' x 5_000_000);
is_problem($answer, 413, 'too-many-bytes', 'who sends on all the same still reads the refusal');
like $large->raw($chunked . $chunk x 15), qr{\AHTTP/1\.1 413 .*"limit":102400}s, 'a body without length is cut at the limit';
my $bad = $large->raw("POST /v1/resample?points=0 HTTP/1.1\r\n${host}Content-Length: 99\r\n\r\n");
like $bad, qr{\AHTTP/1\.1 400 }, 'a wrong parameter is told before the body is sent';
is $large->stop, 0, 'it ends with 0';

# More connections than may be: silent ones go, those who upload stay, and health checks are answered in any case.
my $crowd = Vt->start(connections => 4, threads => 1);
my @idle = map { $crowd->connect } 1 .. 200;
is $crowd->get('/v1/jobs')->{status}, 200, 'a silent crowd keeps nobody out';
sub cut { return scalar grep { my $byte; IO::Select->new($_)->can_read(0) && !$_->sysread($byte, 1) } @_ }
ok wait_until(sub { cut(@idle) >= 160 }), 'who was there first and said nothing is cut';
is $crowd->get('/v1/jobs')->{status}, 200, 'who comes later is served all the same';
$crowd->get('/livez');
my @kept = map { my $one = $crowd->connect; $one->syswrite("GET /livez HTTP/1.1\r\n$host\r\n"); $one } 1 .. 30;
my $answered = 0;
my $read = sub { $answered += grep { my $bytes = ''; IO::Select->new($_)->can_read(0) && $_->sysread($bytes, 4096) && $bytes =~ /alive/ } @kept };
ok wait_until(sub { $read->(); $answered >= 26 }), 'kept connections are answered';
ok wait_until(sub { $crowd->get('/v1/jobs')->{status} == 200 }), 'and make room while they are silent';
my $upload = sub { my $one = $crowd->connect; $one->syswrite("${post}Content-Length: 1000\r\n\r\nply"); $one };
my @busy = map { $upload->() } 1 .. 40;
ok wait_until(sub { push @busy, $upload->(); $crowd->get('/v1/jobs')->{status} == 503 }), 'a busy crowd is turned away';
is_problem($crowd->get('/v1/jobs'), 503, 'too-many-connections', 'with a problem');
is $crowd->get('/livez')->{status}, 200, 'health checks are answered all the same';
close $_ for @idle, @kept, @busy;
ok wait_until(sub { $crowd->get('/v1/jobs')->{status} == 200 }), 'when it is gone jobs are served';
is $crowd->stop, 0, 'it ends with 0';

# A caller who leaves in the middle leaves nothing behind.
sub files { return grep { -f } glob "$daemon->{dir}/data/blobs/* $daemon->{dir}/data/blobs/*/*" }
my $before = files();
my @sockets = map { $daemon->connect } 1 .. 10;
$_->syswrite("${post}Content-Length: 100000\r\n\r\n" . 'x' x 70_000) for @sockets;
ok wait_until(sub { files() > $before }), 'an upload has a file';
close $_ for @sockets;
ok wait_until(sub { files() == $before }), 'that goes when its caller goes';
my $patient = Vt->start;
sub descriptors { return scalar(() = glob "/proc/$patient->{pid}/fd/*") }
$patient->get('/livez');
my $open = descriptors();
for (1 .. 100) {
    my $socket = $patient->connect;
    $socket->syswrite("${post}Content-Length: 100000\r\n\r\n" . 'x' x 1000);
    close $socket;
}
ok wait_until(sub { descriptors() <= $open }), 'also when he goes at once, and long before a deadline';
is $patient->stop, 0, 'it ends with 0';

# Memory while uploading.
sub peak { return Vt::slurp("/proc/$daemon->{pid}/status") =~ /^VmHWM:\s+(\d+) kB/m ? $1 : 0 }
my $socket = $daemon->connect;
my $piece = 'x' x 65536;
my $start = peak();
$socket->print("${post}Content-Length: " . 65536 * 900 . "\r\n\r\n");
$socket->print($piece) for 1 .. 899;
$socket->flush;
my $grown = peak() - $start;
SKIP: {
    skip 'VmHWM means nothing under a sanitizer', 1 if $ENV{VORONOID} && $ENV{VORONOID} =~ /asan|tsan/;
    cmp_ok $grown, '<', 16384, 'an upload of 56 MiB takes less than 16 MiB of memory';
}
$socket->print($piece);
$socket->flush;
like Vt::read_all($socket), qr{\AHTTP/1\.1 415 }, 'it arrived whole';
ok wait_until(sub { files() == $before }), 'and is not kept';
is $daemon->stop, 0, 'it ends with 0';
done_testing;
