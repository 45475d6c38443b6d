#!/usr/bin/perl
# A daemon on a socket in the file system: who may connect, what becomes of one left behind, and the client.
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use IO::Socket::UNIX;
use Test::More;
use Vt;

my $dir = tempdir(CLEANUP => 1);
my $path = "$dir/voronoid.sock";
my $client = $ENV{VORONOID} // 'build/release/voronoid';
my @data = ('--data', "$dir/data", '--threads', 1);

# Starts one; its process, once it listens.
sub start {
    my (@arguments) = @_;
    unlink "$dir/log";
    my $pid = Vt::spawn("$dir/log", @data, @arguments);
    wait_until(sub { Vt::slurp("$dir/log") =~ /"listening","address":"unix:\Q$path\E"/ })
        or die 'it does not listen: ' . Vt::slurp("$dir/log");
    return $pid;
}

sub ask {
    my ($host) = @_;
    my $socket = IO::Socket::UNIX->new(Peer => $path) // die "connect: $!";
    print $socket "GET /v1/jobs HTTP/1.1\r\nHost: $host\r\nConnection: close\r\n\r\n";
    return Vt::read_all($socket);
}

for my $case (['unix:run/x.sock', qr{--listen is "unix:run/x\.sock", want unix:/PATH}],
    ['unix:/' . 'x' x 120, qr/with a path of at most 107 bytes/]) {
    my ($status, $text) = Vt::run(@data, '--listen', $case->[0]);
    is $status, 2, 'a path that no socket can have is refused';
    like $text, $case->[1], 'by name';
}
spew($path, "precious\n");
my ($status, $text) = Vt::run(@data, '--listen', "unix:$path");
is $status, 1, 'a file that is no socket is an error';
like $text, qr/cannot listen on unix:\Q$path\E: there is a file that is not a socket/, 'which is named';
is Vt::slurp($path), "precious\n", 'and the file stays';
unlink $path;

my $pid = start('--listen', "unix:$path", '--socket-mode', '0600', '--admin-listen', "unix:$dir/admin.sock");
is sprintf('%04o', (stat $path)[2] & 07777), '0600', 'the socket has the mode that was asked for';
like ask('localhost'), qr{\AHTTP/1\.1 200 .*"jobs"}s, 'it answers';
{
    my $admin = IO::Socket::UNIX->new(Peer => "$dir/admin.sock") // die "connect: $!";
    print $admin "GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    like Vt::read_all($admin), qr/^voronoid_http_requests_total\{route="\/v1\/jobs",method="GET",code="200"\} 1$/m,
        'and so does an admin listener on a socket';
}
like ask('evil.example'), qr{\AHTTP/1\.1 403 }s, 'Host is checked as on a loopback address';
($status, $text) = Vt::run('--data', "$dir/other", '--listen', "unix:$path");
is $status, 1, 'a second daemon does not take it away';
like $text, qr/a daemon answers there already/, 'and says why';
like Vt::slurp("$dir/log"), qr/"client":"127\.0\.0\.1"/, 'its peers are this machine in the log';

spew("$dir/in.ply", sphere_ply(500));
is system("$client health --server unix:$path >$dir/health"), 0, 'the client asks through it';
is system("VORONOID_LISTEN=unix:$path $client health >$dir/health"), 0, 'and finds it by VORONOID_LISTEN';
is system("$client resample $dir/in.ply -n 100 -o $dir/out.ply --server unix:$path 2>$dir/said"), 0, 'a whole job goes through it'
    or diag Vt::slurp("$dir/said");
like Vt::slurp("$dir/out.ply"), qr/^element vertex 100$/m, 'and comes back';
is system("$client health --server unix:no 2>$dir/said") >> 8, 2, 'a path that is none is refused';
like Vt::slurp("$dir/said"), qr{the server is "unix:no", want unix:/PATH}, 'by name';

kill 'KILL', $pid;
waitpid $pid, 0;
ok -S $path, 'a daemon that was killed leaves its socket';
$pid = start('--listen', "unix:$path");
is sprintf('%04o', (stat $path)[2] & 07777), '0660', 'the next one replaces it';
kill 'TERM', $pid;
is Vt::reap($pid), 0, 'and ends';
ok !-e $path, 'without leaving one';
done_testing();
