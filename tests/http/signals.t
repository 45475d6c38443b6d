#!/usr/bin/perl
# What the daemon makes of signals, and of clients who are slow when it ends.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Time::HiRes qw(time);
use Vt;

my $host = "Host: localhost\r\n";
my $cloud = sphere_ply(2000);

sub said { my ($daemon, $message) = @_; return grep { $_->{msg} eq $message } $daemon->log_lines }

{
    my $daemon = Vt->start;
    kill 'HUP', $daemon->{pid} for 1 .. 3;
    ok wait_until(sub { said($daemon, 'settings reloaded') }), 'SIGHUP has the settings read again';
    is $daemon->get('/livez')->{status}, 200, 'and the daemon goes on';
    kill 'USR2', $daemon->{pid};
    is $daemon->get('/livez')->{status}, 200, 'a signal that means nothing ends nothing';
    is $daemon->stop, 0, 'SIGTERM ends it with 0';
}

for my $signal (qw(QUIT USR1 INT)) {
    my $daemon = Vt->start('drain-timeout' => 0, jobs => 1);
    my $id = $daemon->submit('points=2000&iterations=10000', $cloud);
    ok wait_until(sub { $daemon->status($id) eq 'running' }), 'a job runs';
    is $daemon->stop($signal), 0, "SIG$signal ends the daemon with 0";
    is scalar(said($daemon, 'draining')), 1, 'after a drain';
    is((said($daemon, 'draining'))[0]{signal}, $signal, 'that names it');
    my $again = Vt->start(dir => $daemon->{dir}, 'drain-timeout' => 0);
    like $again->status($id), qr/^(?:accepted|running)$/, 'its job goes on after the next start';
    $again->stop('KILL');
}

# Slow clients have the time of the drain, and no more.
{
    my $daemon = Vt->start('drain-timeout' => 0, 'admin-listen' => '127.0.0.1:0');
    my @slow = map { $daemon->connect } 1 .. 6;
    $_->syswrite("POST /v1/resample?points=9 HTTP/1.1\r\n${host}Content-Length: 1000\r\n\r\nply") for @slow[0 .. 2];
    $_->syswrite("GET /livez HTTP/1.1\r\nHo") for @slow[3, 4];
    $slow[5]->syswrite("GET /livez HTTP/1.1\r\n$host\r\n");
    like Vt::read_all($slow[5], qr/alive/), qr{\AHTTP/1\.1 200 }, 'one is kept';
    ok wait_until(sub { $daemon->metric('uploads_active') == 3 }), 'others are in the middle of a request';
    is $daemon->stop, 0, 'the daemon ends with 0';
    is((said($daemon, 'slow clients are disconnected'))[0]{requests}, 3, 'those whose requests were accepted are counted');
    like Vt::read_all($_), qr{\AHTTP/1\.1 408 .*"retryable":true}s, 'and told that they may come again' for @slow[0 .. 2];
    is Vt::read_all($_), '', 'who has sent no head is cut' for @slow[3, 4];
}

# A balancer has --drain-delay to notice.
{
    my $daemon = Vt->start('drain-delay' => 3600);
    kill 'TERM', $daemon->{pid};
    ok wait_until(sub { $daemon->get('/readyz')->{status} == 503 }), 'it is not ready';
    is $daemon->post('/v1/resample?points=50&iterations=2', $cloud)->{status}, 200, 'and does what it is asked to';
    is $daemon->get('/v1/jobs')->{status}, 200, 'and tells';
    is $daemon->stop, 1, 'until a second signal ends it';

    $daemon = Vt->start('drain-delay' => 0.5);
    my $began = time;
    is $daemon->stop, 0, 'or the delay is over, and it ends with 0';
    cmp_ok time - $began, '>=', 0.5, 'not before';
}

# While it drains, those who are connected are told.
{
    my $daemon = Vt->start('drain-timeout' => 3600, jobs => 1, 'http-threads' => 1);
    $daemon->submit('points=2000&iterations=10000', $cloud);
    my $kept = $daemon->connect;
    my $ask = "GET /readyz HTTP/1.1\r\n$host\r\n";
    kill 'TERM', $daemon->{pid};
    ok wait_until(sub { $daemon->get('/readyz')->{status} == 503 }), 'it drains';
    $kept->syswrite($ask);
    like Vt::read_all($kept, qr/\r\n\r\n/), qr{\AHTTP/1\.1 503 }, 'a connection of before is still answered';
    is $daemon->stop('KILL'), 'signal 9', 'enough';
}
done_testing;
